//! Folders and files that the program may write, and those that it leaves alone.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process,
};

use fingerpost_io::{
    FolderKind, OutputFolder, file_keeps_inputs, folder_keeps_inputs, remove_abandoned, write_file,
};
use proptest::prelude::*;
use tempfile::TempDir;

const KINDS: [FolderKind; 9] = [
    FolderKind::Run,
    FolderKind::CampaignRun,
    FolderKind::Drive,
    FolderKind::Campaign,
    FolderKind::ClosedLoop,
    FolderKind::Tuning,
    FolderKind::Papers,
    FolderKind::Marks,
    FolderKind::Location,
];

/// Names that the program writes in some folder, and others; "frames/" and the like are in folders.
const NAMES: [&str; 21] = [
    "config.toml",
    "fix.jsonl",
    "frames.jsonl",
    "report.html",
    "truth.jsonl",
    "campaign.json",
    "camera.toml",
    "tusimple.json",
    "07.toml",
    "notes.txt",
    ".hidden",
    "frames/000001.jpg",
    "frames/holiday.jpg",
    "pictures/frame_000001.png",
    "pictures/crop.png",
    "road_masks/000001.png",
    "marked_frames/000001.jpg",
    "papers.md",
    "papers/order_road.svg",
    "papers/Notes.svg",
    "deep/er/file",
];

/// The program's own names among them, by kind.
fn is_result(kind: FolderKind, name: &str) -> bool {
    let results: &[&str] = match kind {
        FolderKind::Run => &["config.toml", "frames.jsonl", "report.html", "pictures/frame_000001.png"],
        FolderKind::CampaignRun => {
            &["config.toml", "frames.jsonl", "report.html", "truth.jsonl", "pictures/frame_000001.png"]
        }
        FolderKind::Drive => &["truth.jsonl", "camera.toml", "frames/000001.jpg", "road_masks/000001.png"],
        FolderKind::ConvertedDrive => &["times.txt", "camera.toml", "gps.gpx", "frames/000001.jpg"],
        FolderKind::Campaign => &["campaign.json"],
        FolderKind::ClosedLoop => &["report.html"],
        FolderKind::Tuning => &["report.html", "07.toml"],
        FolderKind::Papers => &["papers.md", "papers/order_road.svg"],
        FolderKind::Marks => &["truth.jsonl", "tusimple.json", "marked_frames/000001.jpg"],
        FolderKind::Location => &["fix.jsonl", "report.html"],
    };
    results.contains(&name)
}

fn kinds() -> impl Strategy<Value = FolderKind> {
    prop::sample::select(&KINDS[..])
}

fn some_names() -> impl Strategy<Value = Vec<&'static str>> {
    prop::sample::subsequence(NAMES.to_vec(), 1..=NAMES.len())
}

fn fill(folder: &Path, names: &[&str]) {
    for name in names {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("the user's {name}")).unwrap();
    }
}

/// Every file of a folder with what is in it.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None,
        rng_seed: prop::test_runner::RngSeed::Fixed(19), ..ProptestConfig::default() })]

    #[test]
    fn a_folder_without_a_marker_is_left_as_it_is(kind in kinds(), names in some_names()) {
        let folder = TempDir::new().unwrap();
        fill(folder.path(), &names);
        let before = contents(folder.path());
        let message = OutputFolder::take(folder.path(), kind).unwrap_err().to_string();
        prop_assert!(message.contains(".fingerpost.json") && message.contains("choose another"), "{message}");
        prop_assert_eq!(contents(folder.path()), before);
    }

    #[test]
    fn a_marked_folder_loses_results_alone(kind in kinds(), names in some_names()) {
        let folder = TempDir::new().unwrap();
        drop(OutputFolder::take(folder.path(), kind).unwrap());
        fill(folder.path(), &names);
        let mut expected = contents(folder.path());
        expected.retain(|path, _| !is_result(kind, path.to_str().unwrap()));
        drop(OutputFolder::take(folder.path(), kind).unwrap());
        prop_assert_eq!(contents(folder.path()), expected);
    }

    #[test]
    fn a_folder_of_another_kind_is_left_as_it_is(a in kinds(), b in kinds(), names in some_names()) {
        prop_assume!(a != b);
        let folder = TempDir::new().unwrap();
        drop(OutputFolder::take(folder.path(), a).unwrap());
        fill(folder.path(), &names);
        let before = contents(folder.path());
        let message = OutputFolder::take(folder.path(), b).unwrap_err().to_string();
        prop_assert!(message.contains(&a.to_string()) && message.contains("choose another"), "{message}");
        prop_assert_eq!(contents(folder.path()), before);
    }

    #[test]
    fn a_file_is_the_old_one_or_the_new_one(old in ".{0,80}", new in ".{0,80}") {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("bank.json");
        write_file(&path, &old).unwrap();
        write_file(&path, &new).unwrap();
        prop_assert_eq!(fs::read_to_string(&path).unwrap(), new);
        prop_assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

#[test]
fn a_folder_in_use_is_refused_and_its_holder_named() {
    let folder = TempDir::new().unwrap();
    let held = OutputFolder::take(folder.path(), FolderKind::Run).unwrap();
    let message = OutputFolder::take(folder.path(), FolderKind::Run).unwrap_err().to_string();
    for word in ["in use by process", &process::id().to_string(), "output_folders", " since 20"] {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
    drop(held);
    // What a killed holder left behind locks nothing.
    fs::write(folder.path().join(".fingerpost.lock"), "{\"pid\": 1, \"command\": \"\\u001b[31m\"").unwrap();
    drop(OutputFolder::take(folder.path(), FolderKind::Run).unwrap());
    assert!(!folder.path().join(".fingerpost.lock").exists());
}

#[test]
fn markers_of_other_versions_are_refused() {
    let folder = TempDir::new().unwrap();
    for marker in ["", "{}", r#"{"version": 2, "kind": "run", "written_by": "fingerpost 9"}"#, "[[[[["] {
        fs::write(folder.path().join(".fingerpost.json"), marker).unwrap();
        let message = OutputFolder::take(folder.path(), FolderKind::Run).unwrap_err().to_string();
        assert!(message.contains("no marker file that this version reads"), "{message}");
    }
}

#[test]
fn a_campaign_is_replaced_with_its_runs() {
    let folder = TempDir::new().unwrap();
    let campaign = || OutputFolder::take(folder.path(), FolderKind::Campaign).unwrap();
    drop(campaign());
    for (name, kind) in [("wet_1", FolderKind::CampaignRun), ("own", FolderKind::Run)] {
        drop(OutputFolder::take(&folder.path().join(name), kind).unwrap());
        fs::write(folder.path().join(name).join("frames.jsonl"), "").unwrap();
    }
    drop(campaign());
    assert!(!folder.path().join("wet_1").exists() && folder.path().join("own/frames.jsonl").exists());
}

#[test]
fn marks_of_earlier_versions_are_gone_on_with() {
    let folder = TempDir::new().unwrap();
    fill(folder.path(), &["marks.json", "truth.jsonl", "marked_frames/000001.jpg"]);
    let before = contents(folder.path());
    drop(OutputFolder::go_on_with(folder.path(), FolderKind::Marks).unwrap());
    fs::remove_file(folder.path().join(".fingerpost.json")).unwrap();
    assert_eq!(contents(folder.path()), before);
    fill(folder.path(), &["notes.txt"]);
    assert!(OutputFolder::go_on_with(folder.path(), FolderKind::Marks).is_err());
}

#[test]
fn what_a_killed_program_left_half_written_goes_and_what_is_being_written_stays() {
    let folder = TempDir::new().unwrap();
    let [abandoned, in_work, other] = ["a", "b", "c"].map(|random| {
        let target = if random == "c" { "other.json" } else { "bank.json" };
        let path = folder.path().join(format!(".{target}.{random}.fingerpost-tmp"));
        fs::write(&path, "half").unwrap();
        path
    });
    let writer = fs::File::open(&in_work).unwrap();
    writer.lock().unwrap();
    remove_abandoned(&folder.path().join("bank.json")).unwrap();
    assert_eq!([&abandoned, &in_work, &other].map(|path| path.exists()), [false, true, true]);
    drop(writer);
    // A folder with nothing else in it is as good as empty.
    drop(OutputFolder::take(folder.path(), FolderKind::Drive).unwrap());
    assert!(!in_work.exists() && !other.exists());
}

#[test]
fn a_device_is_written_to_and_a_protected_file_is_not() {
    write_file(Path::new("/dev/null"), "nothing").unwrap();
    assert!(!Path::new("/dev/null").is_file());
    let message = write_file(Path::new("/dev/full"), "much").unwrap_err().to_string();
    assert!(message.contains("the disk is full"), "{message}");
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("camera.toml");
    fs::write(&path, "mine").unwrap();
    let mut permissions = fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).unwrap();
    let message = write_file(&path, "other").unwrap_err().to_string();
    assert!(message.contains("write-protected"), "{message}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
}

#[cfg(unix)]
mod links {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn an_input_is_known_by_every_name() {
        let folder = TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        fill(folder.path(), &["drive/frames/1.png", "drive/times.txt", "inputs/camera.toml"]);
        let camera = path("inputs/camera.toml");
        symlink(&camera, path("link.toml")).unwrap();
        fs::hard_link(&camera, path("hard.toml")).unwrap();
        symlink(path("inputs"), path("elsewhere")).unwrap();
        let names = ["inputs/camera.toml", "inputs/./../inputs/camera.toml", "link.toml", "hard.toml"];
        for output in names.iter().chain(&["elsewhere/camera.toml"]) {
            for input in names {
                let refused = file_keeps_inputs(&path(output), [path(input).as_path()]).unwrap_err();
                assert!(refused.to_string().contains("would be replaced"), "{refused}");
            }
        }
        for output in ["drive/frames/1.png", "drive/times.txt"] {
            assert!(file_keeps_inputs(&path(output), [path("drive").as_path()]).is_err(), "{output}");
        }
        for output in ["drive/new.toml", "other.toml"] {
            file_keeps_inputs(&path(output), [camera.as_path(), &path("drive")]).unwrap();
        }
    }

    #[test]
    fn inputs_where_results_go_are_refused() {
        let folder = TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        fill(folder.path(), &["run/config.toml", "run/pictures/frame_000001.png", "run/own/camera.toml"]);
        symlink(path("run/config.toml"), path("linked.toml")).unwrap();
        symlink(path("run"), path("linked_run")).unwrap();
        let refused = |out: &str, input: &str| {
            folder_keeps_inputs(&path(out), FolderKind::Run, [path(input).as_path()]).is_err()
        };
        for out in ["run", "linked_run", "./run/own/.."] {
            for input in
                ["run", "run/config.toml", "run/pictures", "run/pictures/frame_000001.png", "linked.toml"]
            {
                assert!(refused(out, input), "{input} in {out}");
            }
            assert!(!refused(out, "run/own/camera.toml") && !refused(out, "gone/config.toml"));
        }
        // Neither has to exist.
        assert!(refused("new", "new/summary.json") && !refused("new", "new/bank.json"));
        let address = [Path::new("rtsp://camera/1")];
        folder_keeps_inputs(&path("run"), FolderKind::Run, address).unwrap();
    }

    #[test]
    fn a_link_in_place_of_a_folder_of_results_is_refused() {
        let folder = TempDir::new().unwrap();
        let [drive, recorded] = ["drive", "recorded"].map(|name| folder.path().join(name));
        drop(OutputFolder::take(&drive, FolderKind::Drive).unwrap());
        fill(&recorded, &["000001.jpg"]);
        symlink(&recorded, drive.join("frames")).unwrap();
        let message = OutputFolder::take(&drive, FolderKind::Drive).unwrap_err().to_string();
        assert!(message.contains("is a link") && recorded.join("000001.jpg").exists(), "{message}");
    }

    #[test]
    fn a_link_is_followed_and_permissions_stay() {
        let folder = TempDir::new().unwrap();
        let [real, link] = ["real.json", "link.json"].map(|name| folder.path().join(name));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        write_file(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
