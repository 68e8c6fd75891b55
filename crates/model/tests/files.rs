//! Models on the disk: what is damaged or does not belong together is refused by name, with the
//! remedy.
#![allow(clippy::unwrap_used, reason = "a panic in a test is a failing test")]

use std::path::PathBuf;

use ppnpack_model::card::ModelCard;
use ppnpack_model::weights::{Model, ModelError, WeightTensor, to_bytes};

const WEIGHTS: &[u8] = include_bytes!("../shipped/ppn.safetensors");
const CARD: &str = include_str!("../shipped/ppn.json");

fn card() -> ModelCard {
    serde_json::from_str(CARD).unwrap()
}

/// A model's files in a folder of their own.
fn files(weights: &[u8], card: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    std::fs::write(&path, weights).unwrap();
    std::fs::write(path.with_extension("json"), card).unwrap();
    (folder, path)
}

/// The message of a model that must be refused.
fn refused(weights: &[u8], card: &str) -> String {
    let (_folder, path) = files(weights, card);
    let message = Model::read(&path).unwrap_err().to_string();
    assert!(message.contains("model."), "no file is named: {message}");
    message
}

/// These weights with a card that has their hash.
fn with_hash(weights: &[u8]) -> Result<Model, ModelError> {
    let card = ModelCard {
        weights_blake3: blake3::hash(weights).to_hex().to_string(),
        ..card()
    };
    Model::new("test.safetensors", weights, card)
}

#[test]
fn the_shipped_model_is_read_from_files_as_it_is_built_in() {
    let (_folder, path) = files(WEIGHTS, CARD);
    let (read, shipped) = (Model::read(&path).unwrap(), Model::shipped().unwrap());
    assert_eq!(read.tensors(), shipped.tensors());
    assert_eq!(read.card().weights_blake3, shipped.card().weights_blake3);
    assert!(WEIGHTS.len() < 8_000_000);
}

#[test]
fn missing_files_are_named_with_the_remedy() {
    let (_folder, path) = files(WEIGHTS, CARD);
    std::fs::remove_file(path.with_extension("json")).unwrap();
    let message = Model::read(&path).unwrap_err().to_string();
    assert!(
        message.contains("model.json") && message.contains("card beside it"),
        "{message}"
    );
    std::fs::remove_file(&path).unwrap();
    let message = Model::read(&path).unwrap_err().to_string();
    assert!(message.contains("model.safetensors"), "{message}");
}

#[test]
fn truncated_and_exchanged_weights_have_another_hash() {
    let half = WEIGHTS.get(..WEIGHTS.len() / 2).unwrap();
    assert!(refused(half, CARD).contains("hash"));
    let mut flipped = WEIGHTS.to_vec();
    *flipped.last_mut().unwrap() ^= 1;
    assert!(refused(&flipped, CARD).contains("hash"));
    // Truncated before the hash was taken: the tensors do not hold together.
    for weights in [half, b""] {
        let message = with_hash(weights).unwrap_err().to_string();
        assert!(message.contains("the weights are damaged"), "{message}");
    }
}

#[test]
fn broken_cards_and_other_formats_are_refused() {
    assert!(refused(WEIGHTS, "{").contains("no model card"));
    assert!(refused(WEIGHTS, "{}").contains("no model card"));
    let other = ModelCard {
        format: 99,
        ..card()
    };
    assert!(refused(WEIGHTS, &serde_json::to_string(&other).unwrap()).contains("train it again"));
    let mut none = card();
    none.architecture.widths.clear();
    let message = refused(WEIGHTS, &serde_json::to_string(&none).unwrap());
    assert!(message.contains("width"), "{message}");
}

#[test]
fn weights_that_are_not_finite_are_refused() {
    let mut tensors = Model::shipped().unwrap().tensors().clone();
    let (name, first) = tensors.first_key_value().unwrap();
    let (name, shape) = (name.clone(), first.shape.clone());
    let mut values = first.values.clone();
    *values.first_mut().unwrap() = f32::NAN;
    tensors.insert(name.clone(), WeightTensor { shape, values });
    let error = with_hash(&to_bytes(&tensors, None).unwrap()).unwrap_err();
    let expected = format!("tensor {name} has a value that is not finite");
    assert!(error.to_string().contains(&expected), "{error}");
}
