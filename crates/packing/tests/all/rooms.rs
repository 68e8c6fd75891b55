//! The rooms of the crate, as its front page says.
use std::fs;
use std::path::Path;

const ROOMS: [&str; 6] = [
    "kernel", "scene", "ranking", "checks", "planning", "streams",
];

/// Adds the names of the rooms that a folder's code uses.
fn add_used(folder: &Path, used: &mut Vec<&str>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            add_used(&path, used);
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code: Vec<&str> = text.lines().map(str::trim_start).collect();
        let code = code.iter().filter(|line| !line.starts_with("//"));
        let uses = |room: &&str| {
            code.clone()
                .any(|line| line.contains(&format!("crate::{room}::")))
        };
        used.extend(ROOMS.into_iter().filter(uses));
    }
}

#[test]
fn each_room_uses_those_before_it_alone() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (at, room) in ROOMS.into_iter().enumerate() {
        let mut used = Vec::new();
        add_used(&src.join(room), &mut used);
        assert!(used.contains(&"kernel"), "{room} reads nothing");
        let later = ROOMS
            .into_iter()
            .skip(at + 1)
            .find(|later| used.contains(later));
        assert_eq!(later, None, "{room} uses a room that uses it");
    }
}
