//! The forced-choice experiment from outside: page, server, analysis, misuse.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

const SCENE: &str = "
camera = { position = [0, 0, 4], target = [0, 0, 0] }
film = { size = [16, 12] }
render = { rays = 4, photons = 200 }
[[medium]]
region = { sphere = { center = [0, 0, 0], radius = 1 } }
sigma_t = 2
albedo = 0.8
[[light]]
type = \"point\"
position = [0, 3, 0]
intensity = [9, 9, 9]
";

/// A name that would be a script in a page that does not escape it.
const HOSTILE: &str = "<img src=x onerror=alert(1)>";

fn fogbow(folder: &Path, args: &[&str]) -> Output {
    let program = assert_cmd::cargo::cargo_bin!("fogbow");
    Command::new(program).current_dir(folder).args(args).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn page_in(folder: &Path) -> String {
    std::fs::write(folder.join("ball.toml"), SCENE).unwrap();
    std::fs::write(folder.join(format!("{HOSTILE}.toml")), SCENE).unwrap();
    let hostile = format!("{HOSTILE}.toml");
    let made = fogbow(folder, &["trial", "ball.toml", &hostile, "-o", "out", "--quiet"]);
    assert!(made.status.success(), "{}", stderr(&made));
    assert_eq!(String::from_utf8_lossy(&made.stdout).trim(), "out/trial.html");
    std::fs::read_to_string(folder.join("out/trial.html")).unwrap()
}

#[test]
fn the_page_is_whole_and_names_are_only_text() {
    let folder = tempfile::tempdir().unwrap();
    let page = page_in(folder.path());
    assert_eq!(page.matches("data:image/png;base64,").count(), 4, "two pictures a scene");
    assert!(!page.contains("<img"), "a scene's name became an element");
    assert!(page.contains("&lt;img"), "but it is told");
    for link in ["src=\"http", "href=\"http", "@import", "url(http", "<link rel=\"stylesheet"] {
        assert!(!page.contains(link), "the page reaches out: {link}");
    }
    let text = std::fs::read(folder.path().join("out/trial.json")).unwrap();
    let told: serde_json::Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(told["scenes"][0]["name"], "ball");
    assert_eq!(told["scenes"][0]["gold"]["director"], "fixed");
    assert_eq!(told["scenes"][0]["directed"]["director"], "xs");
}

/// Answers of 24 people, the first `right` of them right.
fn answers(scene: &str, condition: &str, sides: [&str; 2], right: usize) -> String {
    let row = |person: usize| {
        let gold = sides[person % 2];
        let chosen = if person < right { gold } else { sides[1 - person % 2] };
        format!("p{person},{scene},{condition},{gold},{chosen},1.5,2026-01-01T00:00:00Z\n")
    };
    (0..24).map(row).collect()
}

const HEAD: &str = "participant,scene,condition,gold,chosen,seconds,time\n";

#[test]
fn the_papers_counts_give_its_chi_squares() {
    let folder = tempfile::tempdir().unwrap();
    let successive = [("balls_a", 16), ("balls_b", 17), ("lucy", 20)];
    let text = |rows: &[(&str, usize)], condition: &str, sides: [&str; 2]| {
        let rows = rows.iter().map(|(scene, right)| answers(scene, condition, sides, *right));
        HEAD.to_owned() + &rows.collect::<String>()
    };
    let one = text(&successive, "successive", ["first", "second"]);
    let two = text(&[("lucy", 21), ("road", 22)], "reference", ["left", "right"]);
    std::fs::write(folder.path().join("one.csv"), one).unwrap();
    std::fs::write(folder.path().join("two.csv"), two).unwrap();

    let told = fogbow(folder.path(), &["trial", "--analyse", "one.csv", "two.csv"]);
    assert!(told.status.success(), "{}", stderr(&told));
    let table = String::from_utf8(told.stdout).unwrap();
    let line = |scene: &str, condition: &str| {
        let of = |line: &&str| line.starts_with(scene) && line.contains(condition);
        table.lines().find(of).unwrap().split_whitespace().skip(2).take(5).collect::<Vec<_>>()
    };
    assert_eq!(line("balls_a", "successive"), ["24", "16", "8", "2.67", "0.1025"]);
    assert_eq!(line("balls_b", "successive"), ["24", "17", "7", "4.17", "0.0412"]);
    assert_eq!(line("lucy", "successive"), ["24", "20", "4", "10.67", "0.0011"]);
    assert_eq!(line("lucy", "reference"), ["24", "21", "3", "13.50", "0.0002"]);
    assert_eq!(line("road", "reference"), ["24", "22", "2", "16.67", "4.46e-5"]);

    let told = fogbow(folder.path(), &["trial", "--analyse", "one.csv", "--json"]);
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    let lucy = &told["tallies"][2];
    assert_eq!((&lucy["scene"], &lucy["right"]), (&"lucy".into(), &20.into()));
    assert!((lucy["chi_square"].as_f64().unwrap() - 32.0 / 3.0).abs() < 1e-12);
}

#[test]
fn bad_answers_are_one_line_with_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.csv");
    let good = answers("road", "successive", ["first", "second"], 12);
    let mut rows: Vec<&str> = good.lines().collect();
    rows[2] = "p2,road,successive,first,maybe,1,now";
    std::fs::write(&path, HEAD.to_owned() + &rows.join("\n")).unwrap();
    let told = fogbow(folder.path(), &["trial", "--analyse", "bad.csv"]);
    assert_eq!((told.status.code(), told.stdout.len()), (Some(1), 0));
    let message = stderr(&told);
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("bad.csv: line 4") && message.contains("`maybe`"), "{message}");

    std::fs::write(&path, HEAD).unwrap();
    let told = fogbow(folder.path(), &["trial", "--analyse", "bad.csv"]);
    assert!(stderr(&told).contains("has no answers"), "{}", stderr(&told));
    assert_eq!(fogbow(folder.path(), &["trial", "--analyse", "none.csv"]).status.code(), Some(1));
}

#[test]
fn misuse_is_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.toml"), SCENE).unwrap();
    std::fs::create_dir(folder.path().join("other")).unwrap();
    std::fs::write(folder.path().join("other/ball.toml"), SCENE).unwrap();
    for args in [
        &["trial"][..],
        &["trial", "-o", "out"],
        &["trial", "ball.toml"],
        &["trial", "ball.toml", "--analyse", "a.csv"],
        &["trial", "-o", "out", "--analyse", "a.csv"],
        &["trial", "--serve", "--analyse", "a.csv"],
        &["trial", "--analyse"],
        &["trial", "ball.toml", "-o", "out", "--serve", "99999"],
        &["trial", "ball.toml", "other/ball.toml", "-o", "out"],
    ] {
        let told = fogbow(folder.path(), args);
        assert_eq!(told.status.code(), Some(2), "{args:?}: {}", stderr(&told));
        assert!(!stderr(&told).is_empty());
    }
    let told = fogbow(folder.path(), &["trial", "-o", "out", "--serve"]);
    assert_eq!(told.status.code(), Some(1));
    assert!(stderr(&told).contains("trial.json"), "{}", stderr(&told));
}

/// A running `fogbow trial --serve`, ended with the test.
struct Served {
    child: Child,
    address: String,
}

impl Served {
    fn start(folder: &Path) -> Self {
        let program = assert_cmd::cargo::cargo_bin!("fogbow");
        let mut child = Command::new(program)
            .current_dir(folder)
            .args(["trial", "-o", "out", "--serve", "--quiet"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        let address = url.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
        assert!(address.starts_with("127.0.0.1:"), "{address}");
        Self { child, address }
    }

    /// Status and body of what is answered to a request with these header lines.
    fn ask(&self, request: &str, headers: &str, body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let length = body.len();
        write!(
            stream,
            "{request} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        let mut reply = String::new();
        stream.read_to_string(&mut reply).unwrap();
        let (head, body) = reply.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }

    fn post(&self, body: &str) -> u16 {
        let headers = format!("Host: {}\r\nContent-Type: application/json\r\n", self.address);
        self.ask("POST /answers", &headers, body).0
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn the_server_stores_sound_answers_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let page = page_in(folder.path());
    let served = Served::start(folder.path());
    let host = format!("Host: {}\r\n", served.address);
    assert_eq!(served.ask("GET /", &host, ""), (200, page));
    assert_eq!(served.ask("GET /", "Host: evil.example\r\n", "").0, 403);
    assert_eq!(served.ask("GET /../Cargo.toml", &host, "").0, 404);
    assert_eq!(served.ask("PUT /answers", &host, "").0, 405);

    let answer = |who: &str, scene: &str, chosen: &str| {
        serde_json::json!({
            "participant": who, "scene": scene, "condition": "successive", "gold": "first",
            "chosen": chosen, "seconds": 2.5, "time": "2026-01-01T00:00:00Z",
        })
        .to_string()
    };
    assert_eq!(served.post(&answer("a \"b\", =c", "ball", "first")), 200);
    assert_eq!(served.post(&answer("a \"b\", =c", HOSTILE, "second")), 200);
    assert_eq!(served.post(&answer("a \"b\", =c", "ball", "second")), 409, "one trial a scene");
    assert_eq!(served.post(&answer("bob", "road", "first")), 400, "no such scene");
    assert_eq!(served.post(&answer("bob", "ball", "left")), 400);
    assert_eq!(served.post(&answer("bob\n", "ball", "first")), 400);
    assert_eq!(served.post(&answer("", "ball", "first")), 400);
    assert_eq!(served.post("no answer"), 400);
    assert_eq!(served.post(&answer(&"b".repeat(5000), "ball", "first")), 413);
    let sound = answer("eve", "ball", "first");
    assert_eq!(served.ask("POST /answers", &host, &sound).0, 415);
    drop(served);

    // A last line without its end is no harm, and what was given is known.
    let path = folder.path().join("out/answers.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.trim_end()).unwrap();
    let served = Served::start(folder.path());
    assert_eq!(served.post(&answer("a \"b\", =c", "ball", "first")), 409);
    assert_eq!(served.post(&answer("eve", "ball", "second")), 200);
    drop(served);
    let told = fogbow(folder.path(), &["trial", "--analyse", "out/answers.csv", "--json"]);
    assert!(told.status.success(), "{}", stderr(&told));
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    assert_eq!(told["answers"], 3);
    let counts: Vec<_> = told["tallies"].as_array().unwrap().iter().map(|t| &t["right"]).collect();
    assert_eq!(counts, [&serde_json::json!(0), &serde_json::json!(1)]);

    // Answers that are not ours are not written to.
    std::fs::write(&path, "a,b\n1,2\n").unwrap();
    let told = fogbow(folder.path(), &["trial", "-o", "out", "--serve"]);
    assert_eq!(told.status.code(), Some(1));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "a,b\n1,2\n");
}
