//! `fogbow render --photons-to` and `--photons-from`, from outside.

use std::path::Path;

use tempfile::TempDir;

use crate::parts::{layers, light, report, smoke};
use crate::run;

fn scene() -> String {
    smoke(4, 8000, "[0.95, 0.9, 0.85]")
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), scene()).unwrap();
    folder
}

/// That a render is refused in one line that says all of `says`, and writes no picture.
fn refuses(folder: &Path, args: &[&str], says: &[&str]) {
    let args = [&["render", "s.toml", "--quiet", "-o", "no.exr"], args].concat();
    let (code, out, err) = run(folder, &args);
    assert_eq!((code, out.as_str(), err.lines().count()), (1, "", 1), "{args:?}: {err}");
    assert!(says.iter().all(|words| err.contains(words)), "{says:?}: {err}");
    assert!(!folder.join("no.exr").exists());
}

#[test]
fn pictures_by_saved_photons_have_the_pixels_of_those_that_shoot() {
    let folder = folder();
    let folder = folder.path();
    let grey = ["--set", "medium.0.albedo=0.9", "--set", "light.0.radiance=9.0"];
    let even = ["--set", "medium.0.phase={ type = \"isotropic\" }"];
    for more in [
        &[][..],
        &["--strategy", "beams"],
        &["--strategy", "moments"],
        &["--strategy", "shared-gathers"],
        &["--strategy", "fluence-toward-eye"],
        &["--radius", "0.2"],
        &["--reconstruct"],
        &["--director", "xs"],
        &["--director", "xs", "--x", "scattering"],
        &["--director", "xs-paper"],
        &grey,
        &[&grey[..], &even].concat(),
        &[&even[..], &["--strategy", "beams"]].concat(),
    ] {
        let shot = report(folder, &[more, &["-o", "shot.exr"]].concat());
        let saved = report(folder, &[more, &["--photons-to", "map.fog"]].concat());
        let read =
            report(folder, &[more, &["-o", "read.exr", "--photons-from", "map.fog"]].concat());
        let [one, other] = ["shot.exr", "read.exr"].map(|name| layers(folder, name));
        assert!(one.channels == other.channels, "{more:?}: pixels differ");
        assert_eq!(shot["strategy"], read["strategy"], "{more:?}");
        for name in ["photon_paths", "photons_emitted", "volume_photons", "surface_photons"] {
            let [shot, saved, read] =
                [&shot, &saved, &read].map(|report| report["work"][name].as_u64().unwrap());
            // A director's maps are made by a few photons of their own.
            let is_directed = more.contains(&"--director");
            assert!(shot == saved + read && (is_directed || read == 0), "{more:?}: {name}");
        }
        assert!(shot["work"]["photon_paths"].as_u64() > Some(1000));
        assert_eq!(saved["photons_saved"], read["settings"]["photons_saved"]);
        assert_eq!(other.attributes["fogbow:photons_saved"], saved["photons_saved"]);
    }
}

/// Photons for one camera come with the direct light of media that it sees, and with the optical thickness to it; for any,
/// or with other rays, without.
#[test]
fn cells_that_photons_do_not_fill_are_saved_with_them() {
    let folder = folder();
    let folder = folder.path();
    let even = ["--set", "medium.0.phase={ type = \"isotropic\" }"];
    let counted = |counter: &str, strategy: &str, rays: &str, more: &[&str]| {
        let by = ["--strategy", strategy, "--rays", rays];
        let report = report(folder, &[&by[..], &even, more].concat());
        report["work"][counter].as_u64().unwrap()
    };
    // Photons are aimed by marches, whatever becomes of them.
    let any = ["--photons-to", "any.fog", "--any-camera"];
    let aimed = counted("march_steps", "moments", "128", &any);
    for (strategy, counter, without_cells) in
        [("fluence-toward-eye", "shadow_rays", 0), ("shared-gathers", "march_steps", aimed)]
    {
        let count_by = |rays: &str, more: &[&str]| counted(counter, strategy, rays, more);
        let count = |more: &[&str]| count_by("128", more);
        let shot = count(&["-o", "shot.exr"]);
        let saved = count(&["--photons-to", "map.fog"]);
        let read = count(&["-o", "read.exr", "--photons-from", "map.fog"]);
        assert!(
            saved > 0 && read < shot && saved + read >= shot,
            "{strategy}: {saved}, {read} and {shot}"
        );
        let [shot, read] = ["shot.exr", "read.exr"].map(|name| layers(folder, name));
        assert!(shot.channels == read.channels, "{strategy}: pixels differ");
        assert_eq!(count(&any), without_cells, "{strategy}");
        // The cells of other rays are others.
        let [shot, read] = [&[][..], &["--photons-from", "map.fog"]].map(|more| {
            count_by("16", &[&["-o", "other.exr"], more].concat());
            layers(folder, "other.exr")
        });
        assert!(shot.channels == read.channels, "{strategy}: pixels differ by other rays");
    }
}

#[test]
fn crops_by_saved_photons_merged_are_the_whole() {
    let folder = folder();
    let folder = folder.path();
    report(folder, &["-o", "whole.exr"]);
    report(folder, &["--photons-to", "map.fog"]);
    for (name, crop) in [("left.exr", "0,0,9x20"), ("right.exr", "9,0,15x20")] {
        report(folder, &["-o", name, "--crop", crop, "--photons-from", "map.fog"]);
    }
    let (code, _, err) = run(folder, &["merge", "left.exr", "right.exr", "-o", "out.exr"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let (whole, merged) = (layers(folder, "whole.exr"), layers(folder, "out.exr"));
    assert!(whole.channels == merged.channels, "pixels differ");
    assert_eq!(merged.attributes["fogbow:work:photon_paths"], "0");
    // A crop that shot its photons itself is a part of the same picture.
    report(folder, &["-o", "left.exr", "--crop", "0,0,9x20"]);
    let (code, _, err) = run(folder, &["merge", "left.exr", "right.exr", "-o", "out.exr"]);
    assert_eq!((code, err.as_str()), (0, ""));
}

#[test]
fn the_file_does_not_depend_on_threads() {
    let folder = folder();
    let folder = folder.path();
    for more in [&[][..], &["--strategy", "beams", "--reconstruct"], &["--any-camera"]] {
        let files = ["1", "2"].map(|threads| {
            let name = format!("{threads}.fog");
            report(folder, &[more, &["--photons-to", &name, "--threads", threads]].concat());
            std::fs::read(folder.join(name)).unwrap()
        });
        assert!(files[0] == files[1], "{more:?}");
    }
}

/// Light of pictures by photons for any camera and by those of their own. Noise of both is about 1 %.
#[test]
fn photons_for_any_camera_light_what_each_sees() {
    let folder = folder();
    let folder = folder.path();
    let more = ["--photons", "40000"];
    let even = ["--set", "medium.0.phase={ type = \"isotropic\" }"];
    for (medium, strategy) in [(&[][..], "moments"), (&[], "beams"), (&even, "fluence-toward-eye")]
    {
        let more = [&more[..], medium, &["--strategy", strategy]].concat();
        report(folder, &[&more[..], &["--photons-to", "map.fog", "--any-camera"]].concat());
        for camera in ["[0, 1, 8]", "[6, 3, -2]", "[-1, 5, 3]"] {
            let position = format!("camera.position={camera}");
            let more = [&more[..], &["--set", &position]].concat();
            report(folder, &[&more[..], &["-o", "shot.exr"]].concat());
            let read = ["-o", "read.exr", "--photons-from", "map.fog"];
            let read = report(folder, &[&more[..], &read].concat());
            assert_eq!(read["work"]["photon_paths"], 0);
            assert_eq!(read["strategy"]["media"][0]["strategy"], strategy, "{camera}");
            let [shot, read] = ["shot.exr", "read.exr"].map(|name| light(&layers(folder, name)));
            assert!((read / shot - 1.0).abs() < 0.05, "{strategy} {camera}: {}", read / shot);
        }
    }
}

#[test]
fn photons_for_any_camera_hold_nothing_toward_one() {
    let folder = folder();
    let folder = folder.path();
    let strategy = |more: &[&str]| {
        let more = [more, &["--photons-to", "map.fog", "--any-camera"]].concat();
        report(folder, &more)["strategy"]["media"][0]["strategy"].clone()
    };
    assert_eq!(strategy(&["--strategy", "fluence-toward-eye"]), "beams");
    assert_ne!(strategy(&[]), "fluence-toward-eye");
    // A camera in the medium reads the same photons.
    let inside = ["--set", "camera.position=[0.2, 1.1, 0.3]"];
    report(folder, &["--strategy", "beams", "--photons-to", "map.fog", "--any-camera"]);
    let args = ["--strategy", "beams", "-o", "in.exr", "--photons-from", "map.fog"];
    let (code, _, err) =
        run(folder, &[&["render", "s.toml", "--quiet"], &args[..], &inside].concat());
    assert!(code == 0 || err.contains("save photons by a camera like this one"), "{err}");
}

#[test]
fn photons_of_other_pictures_are_refused() {
    let folder = folder();
    let folder = folder.path();
    report(folder, &["--photons-to", "map.fog"]);
    let from = ["--photons-from", "map.fog"];
    for (more, says) in [
        (&["--set", "medium.0.sigma_t=2.9"][..], "light is "),
        (&["--set", "light.0.u=[2, 0, 0]"], "light is "),
        (&["--set", "camera.position=[0, 1, 7]"], "camera is "),
        (&["--size", "25x20"], "camera is "),
        (&["--seed", "6"], "seed is 5 there and 6 here"),
        (&["--photons", "8001"], "photons is 8000 there and 8001 here"),
        (&["--radius", "0.05"], "radius is null there and 0.05 here"),
        (&["--max-scatter", "4"], "max_scatter is null there and 4 here"),
        (&["--strategy", "beams"], "strategy is \"auto\" there and \"beams\" here"),
        (&["--reconstruct"], "halves is false there and true here"),
    ] {
        let says = ["map.fog: holds the photons of another picture", says, "--photons-to"];
        refuses(folder, &[&from[..], more].concat(), &says);
    }
    // The look of the picture, and its rays, are its own.
    let free = ["--rays", "2", "--exposure", "1", "--crop", "0,0,4x4"];
    report(folder, &[&from[..], &free, &["-o", "free.exr"]].concat());
    report(folder, &["--photons-to", "any.fog", "--any-camera"]);
    let moved = ["--set", "camera.position=[0, 1, 7]", "--size", "25x20"];
    report(folder, &[&["--photons-from", "any.fog", "-o", "any.exr"], &moved[..]].concat());
    let says = ["any.fog", "light is "];
    refuses(
        folder,
        &[
            "--photons-from",
            "any.fog",
            "--set",
            "surface.0.material={ type = \"diffuse\", reflectance = 0.6 }",
        ],
        &says,
    );
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let folder = folder();
    let folder = folder.path();
    report(folder, &["--photons-to", "map.fog"]);
    let whole = std::fs::read(folder.join("map.fog")).unwrap();
    let refuses = |bytes: &[u8]| {
        std::fs::write(folder.join("bad.fog"), bytes).unwrap();
        let says = ["bad.fog: is not a file of saved photons that can be read"];
        refuses(folder, &["--photons-from", "bad.fog"], &says);
    };
    for end in [0, 5, 12, 20, 300, whole.len() / 2, whole.len() - 1] {
        refuses(&whole[..end]);
    }
    for at in [3, 15, whole.len() / 2, whole.len() - 40, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        refuses(&bytes);
    }
    refuses(&[&whole[..], b"more"].concat());
    refuses(scene().as_bytes());
    self::refuses(folder, &["--photons-from", "gone.fog"], &["gone.fog: cannot be read"]);
    self::refuses(folder, &["--photons-from", "."], &[".: is a folder"]);
}

#[test]
fn what_cannot_be_saved_or_read_is_told() {
    let folder = folder();
    let folder = folder.path();
    let fog = "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n[[medium]]\n\
               region = \"everywhere\"\nsigma_t = 0.1\nalbedo = 0.9\n[[light]]\ntype = \"point\"\n\
               position = [0, 3, 0]\nintensity = 9.0\n[render]\nphotons = 2000\n";
    std::fs::write(folder.join("fog.toml"), fog).unwrap();
    let to = ["--photons-to", "map.fog"];
    for (code, scene, more, says) in [
        (2, "s.toml", &["-o", "a.exr"][..], "cannot be used with"),
        (2, "s.toml", &["--pass", "1/2"], "cannot be used with"),
        (2, "s.toml", &["--crop", "0,0,2x2"], "cannot be used with"),
        (2, "s.toml", &["--error", "0.1"], "--photons-to and an error as the goal exclude"),
        (
            1,
            "s.toml",
            &["--max-scatter", "0", "--set", "surface.0.material={ type = \"mirror\" }"],
            "no photons",
        ),
        (1, "fog.toml", &["--any-camera"], "a medium has no end"),
    ] {
        let args = [&["render", scene, "--quiet"], &to[..], more].concat();
        let (found, _, err) = run(folder, &args);
        assert!(found == code && err.contains(says), "{args:?}: {found} {err}");
    }
    for (args, says) in [
        (&["--photons-to", "map.txt"][..], "give a path that ends in .fog"),
        (&["-o", "a.exr", "--any-camera"], "--photons-to"),
        (&["-o", "a.exr", "--photons-from", "map.fog", "--reference"], "cannot be used with"),
        (
            &["-o", "a.exr", "--photons-from", "map.fog", "--error", "0.1"],
            "--photons-from and an error as the goal exclude",
        ),
        (&[], "--output"),
    ] {
        let args = [&["render", "s.toml", "--quiet"], args].concat();
        let (code, _, err) = run(folder, &args);
        assert!(code == 2 && err.contains(says), "{args:?}: {code} {err}");
    }
    assert!(!folder.join("map.fog").exists() && !folder.join("a.exr").exists());
    let (code, _, err) = run(folder, &["render", "fog.toml", "--quiet", "--photons-to", "map.fog"]);
    assert_eq!((code, err.as_str()), (0, ""), "one camera sees a part of endless fog");
}
