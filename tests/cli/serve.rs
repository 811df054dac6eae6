//! `sunfleck serve`: pictures of a scene that stays loaded are those of `render`, and each request is
//! answered.

use crate::program::Studio;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Lines, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use sunfleck::frame_file::FrameFile;

/// A program that waits for requests.
struct Server {
    process: Child,
    requests: ChildStdin,
    events: Lines<BufReader<ChildStdout>>,
}

impl Server {
    fn of(studio: &Studio, line: &str) -> Self {
        let mut command = studio.command(&format!("serve {line} --bake-cache off"));
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let requests = process.stdin.take().unwrap();
        let events = BufReader::new(process.stdout.take().unwrap()).lines();
        let mut server = Self { process, requests, events };
        assert_eq!(server.event()["event"], "ready");
        server
    }

    fn say(&mut self, line: &str) {
        writeln!(self.requests, "{line}").unwrap();
    }

    fn event(&mut self) -> Value {
        serde_json::from_str(&self.events.next().unwrap().unwrap()).unwrap()
    }

    /// The next answer, and how many events came before it.
    fn answer(&mut self) -> (Value, usize) {
        let mut others = 0;
        loop {
            let event = self.event();
            if event["event"] == "answered" {
                return (event, others);
            }
            others += 1;
        }
    }

    fn ask(&mut self, request: &Value) -> Value {
        self.say(&request.to_string());
        self.answer().0
    }

    /// The exit code, once nothing is asked any more.
    fn close(self) -> i32 {
        let Self { mut process, requests, events } = self;
        drop(requests);
        events.for_each(drop);
        process.wait().unwrap().code().unwrap_or(-1)
    }
}

#[test]
fn pictures_are_those_of_render() {
    let studio = Studio::new();
    let mut server = Server::of(&studio, "tiny.ron");
    let flags = "--frames 3 --bounces all --passes depth --camera low";
    for name in ["one.exr", "two.exr"] {
        let mut words: Vec<&str> = flags.split(' ').collect();
        words.extend(["--out", name]);
        let answer = server.ask(&json!({ "id": name, "render": words }));
        assert_eq!(answer, json!({ "event": "answered", "id": name, "outcome": "rendered" }));
    }
    assert_eq!(server.close(), 0);
    studio.succeed(&format!("render tiny.ron {flags} --out three.exr"));
    assert!(studio.bytes("one.exr") == studio.bytes("two.exr"), "what is kept does not show");
    assert!(studio.bytes("one.exr") == studio.bytes("three.exr"), "nor that it was loaded");
}

/// A camera of the scene, said anew, sees what it saw.
#[test]
fn a_camera_may_be_brought_along() {
    let studio = Studio::new();
    let flat = r#"Scene(version: 1, meshes: { "ground": Quad(size_m: 8.0) }, objects: { "ground": (mesh: "ground") },
        cameras: { "viewer": (position_m: (0.5, 3.0, 1.0), look_at_m: (0.5, 0.0, 1.0), fov_deg: 50.0) },
        lights: { "sun": Sun(to_sun: (0.0, 1.0, 0.0), irradiance_w_per_m2: (3.0, 2.0, 1.0)) })"#;
    std::fs::write(studio.path("flat.ron"), flat).unwrap();
    let flags = ["--frames", "1", "--size", "16x9", "--samples", "4", "--bounces", "0", "--out"];
    let render = |out: &'static str| [flags.as_slice(), &[out]].concat();
    // Looks down, with up to -Z.
    let camera = json!({
        "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0.5, 3, 1, 1], "fov_deg": 50, "clip_m": [0.001, 1e9],
    });
    let mut server = Server::of(&studio, "flat.ron");
    let own = server.ask(&json!({ "render": render("own.exr") }));
    let brought = server.ask(&json!({ "render": render("brought.exr"), "camera": camera }));
    assert_eq!((&own["outcome"], &brought["outcome"]), (&json!("rendered"), &json!("rendered")), "{brought}");
    let higher = json!({ "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0.5, 30, 1, 1], "fov_deg": 50 });
    server.ask(&json!({ "render": render("higher.exr"), "camera": higher }));
    server.ask(&json!({ "render": render("again.exr") }));
    assert_eq!(server.close(), 0);
    assert!(studio.bytes("again.exr") == studio.bytes("own.exr"), "the scene's own camera is where it was");
    let [own, brought, higher] = ["own.exr", "brought.exr", "higher.exr"].map(|name| studio.frame(name));
    let red = |file: &FrameFile| file.frame.channel("R").unwrap().pixels.clone();
    let off = red(&own).into_iter().zip(red(&brought)).map(|(own, brought)| (own - brought).abs());
    assert!(off.fold(0.0, f32::max) < 1e-4, "the same picture");
    assert!(
        red(&higher).iter().filter(|red| **red == 0.0).count() > 100,
        "from higher up the ground is small"
    );
}

#[test]
fn what_is_no_request_is_answered_with_the_reason() {
    let studio = Studio::new();
    let mut server = Server::of(&studio, "tiny.ron");
    let eye = |field: &str, value: Value| {
        let mut camera = json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "fov_deg": 40 });
        camera[field] = value;
        json!({ "render": ["--out", "x.exr", "--frames", "1"], "camera": camera }).to_string()
    };
    for (line, reason) in [
        ("nonsense".to_owned(), "no request"),
        // A blank line is none, and has no answer.
        ("\n \n\"\"".to_owned(), "no request"),
        (json!({ "rendr": [] }).to_string(), "unknown field `rendr`"),
        (json!({ "render": ["--nonsense"] }).to_string(), "--nonsense"),
        (json!({ "render": ["--threads", "2"] }).to_string(), "said to `serve`"),
        (json!({ "render": ["--strict"] }).to_string(), "said to `serve`"),
        (json!({ "render": ["--dry-run"] }).to_string(), "--dry-run"),
        (json!({ "render": ["--camera", "nobody"] }).to_string(), "nobody"),
        (json!({ "render": ["--frames", "99"] }).to_string(), "99"),
        (eye("fov_deg", json!(180)), "fov_deg"),
        (eye("height_m", json!(2)), "height_m"),
        (eye("matrix", json!([0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])), "matrix"),
        (eye("clip_m", json!([2, 1])), "clip_m"),
        (eye("aperture", json!({ "f_stop": 0, "focus_distance_m": 1, "sensor_width_m": 1 })), "aperture"),
    ] {
        server.say(&line);
        let (answer, events) = server.answer();
        assert_eq!((&answer["outcome"], events), (&json!("refused"), 0), "{line}: {answer}");
        assert!(answer["error"].as_str().unwrap().contains(reason), "{line}: {answer}");
    }
    let unknown = server.ask(&json!({ "id": 9, "rendr": [] }));
    assert_eq!(unknown["id"], 9, "{unknown}");
    server.requests.write_all(b"\xff\n").unwrap();
    assert_eq!(server.answer().0["outcome"], "refused", "what is no text");
    let good = server.ask(&json!({ "id": [1, "x"], "render": ["--out", "x.exr", "--frames", "1"] }));
    assert_eq!((&good["outcome"], &good["id"]), (&json!("rendered"), &json!([1, "x"])));
    assert_eq!(server.close(), 0);
    assert_eq!(studio.names("").iter().filter(|name| name.ends_with(".exr")).count(), 1);
}

/// Hours of samples end at the next request, whether it wants a picture or not.
#[test]
fn a_newer_request_ends_the_one_under_way() {
    let studio = Studio::new();
    let mut server = Server::of(&studio, "tiny.ron");
    let render = |samples: &str| json!({ "id": samples, "render": ["--frames", "1", "--samples", samples, "--out", "x.exr"] });
    for next in [render("1"), json!({})] {
        server.say(&render("65536").to_string());
        assert_eq!(server.event()["event"], "started");
        server.say(&next.to_string());
        let (ended, _) = server.answer();
        assert_eq!((&ended["id"], &ended["outcome"]), (&json!("65536"), &json!("ended")));
        assert_eq!(server.answer().0["id"], next["id"]);
    }
    server.say(&render("65536").to_string());
    assert_eq!(server.event()["event"], "started");
    assert_eq!(server.close(), 0, "nobody asks any more");
}

#[test]
fn a_scene_that_cannot_be_loaded_is_refused_as_by_render() {
    let studio = Studio::new();
    let render = studio.fail("render nowhere.ron --out x.exr", 4);
    assert_eq!(studio.fail("serve nowhere.ron", 4), render);
}
