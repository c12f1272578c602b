//! Where Open Image Denoise may be.

use std::cmp::Reverse;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The library's name, as the loader knows it.
pub(super) const NAME: &str = if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// Where `pip install pyoidn` puts it in a folder of packages.
const IN_PACKAGES: &str = "pyoidn/oidn/lib";

/// What the library and its modules are linked with, by the beginning of the name, in the order in
/// which they are needed.
const DEPENDENCIES: [&str; 2] = ["libtbb.so", "libOpenImageDenoise_core.so"];

/// Prints the folders in which Python looks for packages.
const TELL_PACKAGES: &str =
    "import site, sys; print(*sys.path, site.getusersitepackages(), sep='\\n')";

/// A variable of the environment, where it is set and not empty.
pub(super) type Variable<'a> = &'a dyn Fn(&str) -> Option<OsString>;

/// The file that `given` names: itself, or the library in the folder that it is.
///
/// # Errors
/// What is there instead, and what would be right.
pub(super) fn given(given: &Path) -> Result<PathBuf, String> {
    let wanted = format!("FOGBOW_OIDN must be the file {NAME} or a folder that holds it");
    match std::fs::metadata(given) {
        Err(e) => Err(format!("cannot be found: {e}; {wanted}")),
        Ok(data) if !data.is_dir() => Ok(given.to_path_buf()),
        Ok(_) => {
            let places = ["", "lib"].map(|folder| given.join(folder).join(NAME));
            let found = places.into_iter().find(|file| file.is_file());
            found.ok_or_else(|| format!("is a folder without {NAME}; {wanted}"))
        }
    }
}

/// The libraries in Python environments, first the one to take first: of `VIRTUAL_ENV`, of
/// `CONDA_PREFIX`, of the `python3` in `PATH` and of the user.
pub(super) fn in_python(variable: Variable<'_>) -> Vec<PathBuf> {
    let active = ["VIRTUAL_ENV", "CONDA_PREFIX"].into_iter().filter_map(variable);
    let mut packages: Vec<PathBuf> =
        active.flat_map(|prefix| packages_below(Path::new(&prefix))).collect();
    if let Some(python) = python(variable) {
        packages.extend(packages_of(&python));
    }
    let user = variable("PYTHONUSERBASE").map(PathBuf::from);
    let home = || variable("HOME").map(|home| Path::new(&home).join(".local"));
    packages.extend(user.or_else(home).iter().flat_map(|base| packages_below(base)));
    let mut found = Vec::new();
    for file in packages.iter().map(|packages| packages.join(IN_PACKAGES).join(NAME)) {
        if file.is_file() && !found.contains(&file) {
            found.push(file);
        }
    }
    found
}

/// What lies beside the library at `path` and is to be loaded before it: the library looks for it in
/// folders named `lib` alone.
pub(super) fn dependencies(path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().filter(|folder| !["", "lib"].contains(&name(folder)));
    let files = folder.map_or_else(Vec::new, entries);
    let beside = |start: &&str| {
        let named = |file: &&PathBuf| name(file).starts_with(start);
        files.iter().filter(named).max().cloned()
    };
    DEPENDENCIES.iter().filter_map(beside).collect()
}

/// The first `python3` in `PATH`.
fn python(variable: Variable<'_>) -> Option<PathBuf> {
    let path = variable("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join("python3")).find(|file| file.is_file())
}

/// Where `python` looks for packages: by the folders beside it, else by what it says itself, as the
/// ones that only call another do.
fn packages_of(python: &Path) -> Vec<PathBuf> {
    let real = python.canonicalize().unwrap_or_default();
    let prefixes = [python, &real].into_iter().filter_map(|file| file.parent()?.parent());
    // Debian's own Python has those of the machine's administrator below /usr/local.
    let prefixes = prefixes.flat_map(|prefix| [prefix.to_path_buf(), prefix.join("local")]);
    let packages: Vec<PathBuf> = prefixes.flat_map(|prefix| packages_below(&prefix)).collect();
    if packages.is_empty() { packages_told_by(python) } else { packages }
}

fn packages_told_by(python: &Path) -> Vec<PathBuf> {
    let told = Command::new(python)
        .args(["-c", TELL_PACKAGES])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    let told = told.map(|output| output.stdout).unwrap_or_default();
    String::from_utf8_lossy(&told).lines().filter(|l| !l.is_empty()).map(PathBuf::from).collect()
}

/// The folders of packages below the prefix of an environment, those of the latest Python first.
fn packages_below(prefix: &Path) -> Vec<PathBuf> {
    let mut versions: Vec<PathBuf> = entries(&prefix.join("lib"));
    versions.retain(|folder| name(folder).starts_with("python3"));
    let minor = |folder: &PathBuf| {
        name(folder).strip_prefix("python3.").and_then(|minor| minor.parse::<u32>().ok())
    };
    versions.sort_by_key(|folder| Reverse(minor(folder)));
    let packages = |folder: PathBuf| ["site-packages", "dist-packages"].map(|p| folder.join(p));
    versions.into_iter().flat_map(packages).filter(|folder| folder.is_dir()).collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut entries: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    entries.sort();
    entries
}

fn name(path: &Path) -> &str {
    path.file_name().and_then(OsStr::to_str).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// An empty file in the place of the library in the Python environment at `prefix`.
    fn installed(prefix: &Path, python: &str, packages: &str) -> PathBuf {
        let folder = prefix.join("lib").join(python).join(packages).join(IN_PACKAGES);
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join(NAME);
        fs::write(&file, "").unwrap();
        file
    }

    fn search(variables: &[(&str, &Path)]) -> Vec<PathBuf> {
        in_python(&|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| value.as_os_str().to_owned())
        })
    }

    #[test]
    fn environments_are_looked_through_in_their_order_and_the_latest_python_first() {
        let root = tempfile::tempdir().unwrap();
        let [virtual_env, conda, usr, home] =
            ["virtual_env", "conda", "usr", "home"].map(|name| root.path().join(name));
        fs::create_dir_all(usr.join("bin")).unwrap();
        fs::write(usr.join("bin/python3"), "").unwrap();
        let mut expected = vec![
            installed(&virtual_env, "python3.12", "site-packages"),
            installed(&virtual_env, "python3.9", "site-packages"),
            installed(&conda, "python3.11", "site-packages"),
            installed(&usr, "python3", "dist-packages"),
            installed(&usr.join("local"), "python3.11", "dist-packages"),
            installed(&home.join(".local"), "python3.11", "site-packages"),
        ];
        let path = usr.join("bin");
        let all = [
            ("VIRTUAL_ENV", &*virtual_env),
            ("CONDA_PREFIX", &*conda),
            ("PATH", &*path),
            ("HOME", &*home),
        ];
        let canonical = |files: Vec<PathBuf>| -> Vec<PathBuf> {
            let mut files: Vec<_> = files.iter().map(|file| file.canonicalize().unwrap()).collect();
            files.dedup();
            files
        };
        assert_eq!(canonical(search(&all)), canonical(expected.clone()));
        assert_eq!(search(&all[1..2]), [expected.remove(2)]);
        assert_eq!(search(&[]), [] as [PathBuf; 0]);
    }

    #[test]
    fn what_python_itself_says_counts_where_nothing_lies_beside_it() {
        use std::os::unix::fs::PermissionsExt;
        let root = tempfile::tempdir().unwrap();
        let file = installed(&root.path().join("versions"), "python3.11", "site-packages");
        let packages = root.path().join("versions/lib/python3.11/site-packages");
        let shims = root.path().join("shims");
        fs::create_dir(&shims).unwrap();
        let shim = shims.join("python3");
        fs::write(&shim, format!("#!/bin/sh\necho; echo '{}'\n", packages.display())).unwrap();
        fs::set_permissions(&shim, fs::Permissions::from_mode(0o755)).unwrap();
        assert_eq!(search(&[("PATH", &shims)]), [file]);
    }

    #[test]
    fn a_folder_or_a_file_may_be_given() {
        let root = tempfile::tempdir().unwrap();
        let lib = root.path().join("lib");
        fs::create_dir(&lib).unwrap();
        assert!(given(root.path()).unwrap_err().contains("is a folder without"));
        let file = lib.join(NAME);
        fs::write(&file, "").unwrap();
        for right in [root.path(), &lib, &file] {
            assert_eq!(given(right).unwrap(), file);
        }
        let message = given(&root.path().join("nothing")).unwrap_err();
        assert!(
            message.contains("cannot be found") && message.contains("FOGBOW_OIDN"),
            "{message}"
        );
    }

    #[test]
    fn what_it_is_linked_with_is_taken_from_its_folder() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        for name in ["libtbb.so.12", "libOpenImageDenoise_core.so.2.5.1", NAME, "libsycl.so.9"] {
            fs::write(at(name), "").unwrap();
        }
        let expected = [at("libtbb.so.12"), at("libOpenImageDenoise_core.so.2.5.1")];
        assert_eq!(dependencies(&at(NAME)), expected);
        assert!(dependencies(Path::new(NAME)).is_empty());
        let lib = root.path().join("lib");
        fs::create_dir(&lib).unwrap();
        fs::write(lib.join("libtbb.so.12"), "").unwrap();
        assert!(dependencies(&lib.join(NAME)).is_empty());
    }
}
