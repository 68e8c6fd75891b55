//! What the page of every experiment keeps to.

use std::path::Path;

/// Elements that are never closed.
const VOID: [&str; 5] = ["!doctype", "br", "hr", "img", "meta"];

/// The page of an experiment says first what was asked and what came out, with a picture; it needs nothing from elsewhere, and its
/// elements end in order.
pub(crate) fn answers_first(folder: &Path, question: &str) {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let head = format!("<h1>{question}</h1><p class=said>");
    let (_, said) = page.split_once(&head).unwrap_or_default();
    let (answer, further) = said.split_once("</p>").unwrap_or_default();
    assert!(answer.len() > 30 && answer.ends_with('.'), "{answer}");
    assert!(
        !answer.contains("NaN") && !answer.contains("inf "),
        "{answer}"
    );
    let (picture, _) = further.split_once("<h2>").unwrap();
    let is_drawn = picture.contains("<svg") || picture.contains("data:image/png;base64,");
    assert!(is_drawn, "{picture}");
    for part in ["src=\"http", "href", "url(", "<script"] {
        assert!(!page.contains(part), "{part}");
    }
    for part in ["<table>", ">Command<", "ppnpack experiment", "<pre>{"] {
        assert!(page.contains(part), "{part}");
    }
    is_balanced(&page);
}

fn is_balanced(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    for part in page.split('<').skip(1) {
        let (tag, _) = part.split_once('>').unwrap();
        if let Some(ended) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(ended), "{part}");
        } else if !tag.ends_with('/') {
            let name = tag.split_whitespace().next().unwrap();
            open.extend(Some(name).filter(|name| !VOID.contains(name)));
        }
    }
    assert!(open.is_empty(), "{open:?}");
}
