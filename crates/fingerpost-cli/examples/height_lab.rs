//! Lab: run the pipeline over a folder and dump per frame grey ground view, height log-odds and probability (raw).
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]
use std::io::Write;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_io::{picture_paths, read_camera, read_picture};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let camera = read_camera(args[2].as_ref()).unwrap();
    let mut config = Config::default();
    config.lanes.finder = serde_json::from_str("\"off\"").unwrap();
    if args.len() > 4 { config = toml::from_str(&std::fs::read_to_string(&args[4]).unwrap()).unwrap(); }
    let mut pipeline = Pipeline::new(&config, &camera, None, None).unwrap();
    let out = std::path::PathBuf::from(&args[3]);
    std::fs::create_dir_all(&out).unwrap();
    let mut text = std::fs::File::create(out.join("pairs.txt")).unwrap();
    let mut total = 0.0; let mut n = 0; let mut worst: f64 = 0.0;
    for (i, path) in picture_paths(args[1].as_ref()).unwrap().iter().enumerate() {
        let frame = read_picture(path).unwrap();
        let mut last = std::time::Instant::now();
        let mut t_height = 0.0;
        let (output, evidence) = pipeline.step(&frame, Sensors { dt_s: Some(0.1), ..Sensors::default() }, &mut |stage| {
            let now = std::time::Instant::now();
            if stage == fingerpost::Stage::Height { t_height = (now - last).as_secs_f64() * 1e3; }
            last = now;
        }).unwrap();
        total += t_height; n += 1; worst = worst.max(t_height);
        let m = output.motion.map(|m| m.previous_from_current.translation.x).unwrap_or(0.0);
        if let Some((height, how)) = evidence.height {
            writeln!(text, "{i} {m:.3} {t_height:.2} {:?}", how.pairs).unwrap();
            let mut f = std::fs::File::create(out.join(format!("{i:05}.raw"))).unwrap();
            for v in [evidence.ground.grey.width(), evidence.ground.grey.height(), height.raised.width(), height.raised.height()] { f.write_all(&(v as u32).to_le_bytes()).unwrap(); }
            f.write_all(evidence.ground.grey.as_slice()).unwrap();
            f.write_all(evidence.surface.probability.as_slice()).unwrap();
            for v in height.raised.as_slice() { f.write_all(&v.to_le_bytes()).unwrap(); }
        }
    }
    println!("height {:.2} ms mean, {worst:.2} worst", total / f64::from(n));
}
