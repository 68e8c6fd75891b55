//! The ways to plan that are compared.

use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::kernel::objective::Weights;
use ppnpack_packing::planning::method::{Method, ProposalSource, Stability};
use ppnpack_packing::ranking::scene_value::SceneValue;

use crate::packer::sdfm;

pub(super) type Contender = (String, Method);

/// Names the files of a contender: `tried-network` for `tried, network, K = 20 %`.
pub(super) fn key(name: &str) -> String {
    let parts: Vec<&str> = name.split(", ").take(2).collect();
    parts.join("-").replace(' ', "-")
}

/// The physical stability test, the yardstick; then placements that are tried, also with other
/// weights, with the value of what is left, and with the network's proposals where there are any.
pub(super) fn contenders(
    buffer: usize,
    seed: u64,
    network: Option<ProposalSource>,
) -> Vec<Contender> {
    let with = |proposals, stability| sdfm(proposals, stability, buffer, seed);
    let tried = |proposals| Method {
        trial: TrialSettings::default(),
        weights: Some(Weights::low()),
        ..with(proposals, Stability::None)
    };
    let tested = with(ProposalSource::Bounded, Stability::Physical);
    let dense = Method {
        weights: Some(Weights::dense()),
        ..tried(ProposalSource::Bounded)
    };
    let valued = Method {
        scene_value: SceneValue::default(),
        ..tried(ProposalSource::Bounded)
    };
    let mut contenders = vec![
        ("physical test".to_owned(), tested),
        ("tried".to_owned(), tried(ProposalSource::Bounded)),
        ("tried, dense".to_owned(), dense),
        ("tried, valued".to_owned(), valued),
    ];
    if let Some(proposals) = network {
        contenders.push((format!("tried, {proposals}"), tried(proposals)));
    }
    contenders
}
