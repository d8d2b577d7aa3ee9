//! Draws a painted drive and its report, to be looked at: `cargo run -p fingerpost-report --example preview -- DIR`.

#[path = "../tests/report/painted_run.rs"]
mod painted_run;

use std::fs::File;
use std::path::Path;

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_report::{ReportInput, StagePictures, Thresholds, Timeline, compose, report_html};
use fingerpost_vision::picture::RgbImage;
use painted_run::painted_run;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("give the folder to write to")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let mount = Mount { pitch_rad: 8_f64.to_radians(), x_m: 1.5, ..Mount::level(1.5) };
    let lens = |f: f64, cx, cy| Intrinsics { fx: f, fy: f, cx, cy };
    let wide = Camera::calibrated(1241, 376, lens(718.0, 607.2, 120.0), Distortion::None, mount)?;
    let high = Camera::calibrated(1280, 720, lens(840.0, 639.5, 359.5), Distortion::None, mount)?;
    for (name, camera) in [("vga", painted_run::camera()), ("wide", wide), ("high", high)] {
        let run = painted_run(&camera, "Milkmaid's Lane × <Orchard> Road", &mut |scene| {
            if matches!(scene.frame, 2 | 17 | 27 | 33) {
                let file = folder.join(format!("{name}_{:02}.png", scene.frame));
                write(&file, &compose(scene)).unwrap_or_default();
            }
            if scene.frame == 17 {
                for stage in StagePictures::draw(scene).pictures {
                    let file = folder.join(format!("{name}_{}.png", stage.stage.replace(' ', "_")));
                    write(&file, &stage.picture).unwrap_or_default();
                }
            }
        });
        let input = ReportInput {
            title: "painted drive",
            timeline: &Timeline::of(&run.records, Some(&run.truth)),
            summary: &run.summary,
            truth: Some(&run.truth),
            route: Some(&run.route),
            roads: None,
            thresholds: Thresholds { detect: 0.8, lost: 0.5 },
            made_from: &[("command", "cargo run --example preview".to_owned())],
            rules: &[],
            config_toml: "[track]\ndetect_present = 0.8\n",
            key_frames: &run.key_frames,
        };
        std::fs::write(folder.join(format!("{name}.html")), report_html(&input))?;
    }
    Ok(())
}

fn write(file: &Path, picture: &RgbImage) -> Result<(), Box<dyn std::error::Error>> {
    let mut encoder = png::Encoder::new(File::create(file)?, picture.width() as u32, picture.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(picture.as_slice())?;
    Ok(())
}
