//! Commands as functions: pictures in memory beside those of the program.

use std::fs;
use std::path::Path;

use fogbow::cli::calls::{self, Compared};
use fogbow::cli::{PictureInMemory, SharedPhotons};
use fogbow::render::{Silent, Stop};
use fogbow::scene::OpenScene;
use serde_json::Value;

use crate::parts::{report, smoke};

/// A flag as the word that [`calls`] take.
fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

fn render(open: &mut OpenScene, text: &str, shared: &mut SharedPhotons) -> PictureInMemory {
    let stop = Stop::default();
    calls::render(open, None, &words(text), shared, &Silent, &stop).unwrap()
}

#[test]
fn a_picture_in_memory_has_the_files_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = smoke(2, 2000, "0.9");
    fs::write(folder.join("s.toml"), &text).unwrap();
    let mut open = OpenScene::of_text(Path::new("dict"), text);
    for flags in
        ["--seed=7", "--reference", "--reconstruct --rays=4", "--crop=2,3,9x8 --exposure=1"]
    {
        let program: Vec<String> = words(&flags.replace('=', " "));
        let program: Vec<&str> = program.iter().map(String::as_str).collect();
        let told = report(folder, &[&program[..], &["-o", "a.exr"]].concat());
        let picture = render(&mut open, flags, &mut SharedPhotons::default());
        assert_eq!(picture.report["settings"], told["settings"], "{flags}");
        assert_eq!(picture.report["work"], told["work"], "{flags}");
        for ending in ["exr", "png"] {
            let path = folder.join("b").with_extension(ending);
            picture.save(&path).unwrap();
            let files =
                [folder.join("a").with_extension(ending), path].map(|p| fs::read(p).unwrap());
            assert!(files[0] == files[1], "{flags}: .{ending} differs");
        }
    }
    let refused = calls::load(&mut open, None, &words("--rays=0")).unwrap_err().to_string();
    assert!(refused.contains("--rays") && refused.contains("1048576"), "{refused}");
}

#[test]
fn pictures_of_a_list_share_photons_and_have_the_pixels_of_each_alone() {
    let text = smoke(2, 4000, "0.9");
    let open = || OpenScene::of_text(Path::new("dict"), text.clone());
    let list = ["", "--director=x --x=scattering", "--rays=3", "--exposure=1", "--seed=8"];
    let settings: Vec<_> = list.iter().map(|flags| (None, words(flags))).collect();
    let mut kept = open();
    let mut shared = calls::share_photons(&mut kept, &settings).unwrap();
    for (flags, shares) in list.iter().zip([true, true, false, true, false]) {
        let alone = render(&mut open(), flags, &mut SharedPhotons::default());
        let listed = render(&mut kept, flags, &mut shared);
        assert!(alone.film == listed.film, "{flags}: pixels differ");
        let [alone, listed] = [alone, listed].map(|picture| picture.report);
        assert_eq!(alone["settings"], listed["settings"], "{flags}");
        assert_eq!(listed["seconds"].get("shared photons").is_some(), shares, "{flags}");
    }
}

#[test]
fn reports_are_those_of_the_program() {
    let open = || OpenScene::of_text(Path::new("dict"), smoke(2, 2000, "0.9"));
    let read = |text: String| serde_json::from_str::<Value>(&text).unwrap();
    let plan = read(calls::plan(&mut open(), &words("--rays=3")).unwrap());
    assert_eq!(plan["rays"], 3);
    let maps = calls::maps(&mut open(), &[]).unwrap();
    let xs = maps.iter().find(|map| map.name == "xs").unwrap();
    assert_eq!(xs.shape, [20, 24]);
    let picture = render(&mut open(), "", &mut SharedPhotons::default());
    let image = || Compared::Image(picture.film.image());
    let errors = read(calls::compare(&image(), &image(), &[]).unwrap());
    assert_eq!(errors["errors"]["mse"], 0.0);
    let flags = calls::flags("render");
    let has = |name: &str| flags.iter().find(|flag| flag.name == name).map(|flag| flag.has_value);
    let found = ["rays", "denoise", "threads", "output", "json", "frames"].map(has);
    assert_eq!(found, [Some(true), Some(false), Some(true), None, None, None]);
}
