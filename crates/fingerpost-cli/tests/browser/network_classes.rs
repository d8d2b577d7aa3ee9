//! What the road network sees, over the picture of a run.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::chromium::Page;
use crate::simulated_run::Run;

/// The network's classes lie over the picture, which they colour as their legend says: several of them somewhere.
pub(crate) fn shows_what_the_network_sees(page: &mut Page) {
    page.value("document.querySelector('#classes input').click()");
    page.wait_for("document.querySelector('#stage img.classes')?.naturalWidth === 320");
    let coloured = page.value(
        "(() => {
            const pixels = (image) => {
                const canvas = document.createElement('canvas'); [canvas.width, canvas.height] = [320, 240];
                const drawing = canvas.getContext('2d'); drawing.drawImage(image, 0, 0);
                return drawing.getImageData(0, 0, 320, 240).data;
            };
            const [under, over] = ['#picture', '#stage img.classes'].map((which) => pixels(document.querySelector(which)));
            const colours = [...document.querySelectorAll('#classes i')].map((swatch) => swatch.style.background.match(/\\d+/g).map(Number));
            const counts = colours.map(() => 0);
            for (let at = 0; at < under.length; at += 4) {
                const change = [0, 1, 2].map((channel) => over[at + channel] - under[at + channel]);
                if (Math.hypot(...change) < 40) continue;
                const off = colours.map((colour) => {
                    const toward = colour.map((value, channel) => value - under[at + channel]);
                    const along = change.reduce((sum, value, channel) => sum + value * toward[channel], 0);
                    return 1 - along / Math.hypot(...change) / Math.hypot(...toward);
                });
                counts[off.indexOf(Math.min(...off))] += 1;
            }
            return counts;
        })()",
    );
    let coloured: Vec<u64> = coloured.as_array().unwrap().iter().filter_map(Value::as_u64).collect();
    println!("pixels of road, raised ground, what hides it and paint: {coloured:?}");
    assert!(coloured.len() == 4 && coloured.iter().filter(|count| **count > 100).count() > 1, "{coloured:?}");
    page.value("scrollTo(0, 0)");
    page.screenshot(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("look_classes.png"));
    page.value("document.querySelector('#classes input').click()");
    page.wait_for("!document.querySelector('#stage img.classes')");
}

#[test]
fn a_run_without_a_network_says_so() {
    let run = Run::make(5);
    let settings = run.path("settings.toml");
    fs::write(&settings, "[road_surface.memory]\nof = \"backprojection\"\n").unwrap();
    run.again("run", &format!("--config {}", settings.display()));
    let served = run.serve("--input", &run.drive());
    let mut page = Page::open(&served.address);
    page.wait_for("document.getElementById('classes').textContent.includes('asks no network')");
    assert_eq!(page.value("document.querySelector('#classes input')"), Value::Null);
    page.wait_for("document.body.dataset.ready === 'yes'");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
