//! What the program says about itself.

use std::fs;

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, summary};

#[test]
fn version_and_configuration_name_the_same_program() {
    let version = call_line("--version").done().stdout;
    let version = version.trim();
    assert!(version.starts_with(concat!("fingerpost ", env!("CARGO_PKG_VERSION"))), "{version}");
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    call_line(&format!("{} --frames 3", drive.run_line(&drive.path(), &first))).done();
    let config = fs::read_to_string(first.join("config.toml")).unwrap();
    assert_eq!(config.lines().next(), Some(format!("# Written by {version}").as_str()));
    assert_eq!(summary(&first).written_by.as_deref(), Some(version));
    assert!(
        fs::read_to_string(first.join("report.html")).unwrap().contains(&format!("Written by {version}."))
    );
    let again = format!("--config {} --frames 3", first.join("config.toml").display());
    call_line(&format!("{} {again}", drive.run_line(&drive.path(), &second))).done();
    assert_eq!(fs::read_to_string(second.join("config.toml")).unwrap(), config);
}

#[test]
fn the_program_carries_the_licences_of_what_it_holds() {
    let notices = call_line("licences").done().stdout;
    let lock = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.lock")).unwrap();
    let lock: toml::Table = toml::from_str(&lock).unwrap();
    for name in ["hyper", "nalgebra", "zune-jpeg", "quick-xml", "prost"] {
        let packages = lock["package"].as_array().unwrap().iter();
        let package = packages.clone().find(|package| package["name"].as_str() == Some(name)).unwrap();
        let named = format!("\n{name} {} (", package["version"].as_str().unwrap());
        assert!(notices.contains(&named), "{named}");
    }
    for words in
        ["Permission is hereby granted, free of charge", "Apache License", "OpenStreetMap contributors"]
    {
        assert!(notices.contains(words), "{words}");
    }
}
