//! The ways to plan that are compared.

use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_packing::objective::Weights;
use ppnpack_packing::scene_value::SceneValue;
use ppnpack_packing::trial::TrialSettings;

use crate::packer::sdfm;

/// A way to plan.
pub(super) struct Contender {
    pub(super) name: String,
    /// What files are named by.
    pub(super) key: &'static str,
    pub(super) method: Method,
}

impl Contender {
    fn new(name: impl Into<String>, key: &'static str, method: Method) -> Self {
        Self {
            name: name.into(),
            key,
            method,
        }
    }
}

/// The physical stability test, which the others are compared with; then placements that are tried, also with other weights, with
/// the value of what is left, and with the network's proposals where there are any.
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
        Contender::new("physical test", "physical-test", tested),
        Contender::new("tried", "tried", tried(ProposalSource::Bounded)),
        Contender::new("tried, dense", "tried-dense", dense),
        Contender::new("tried, valued", "tried-valued", valued),
    ];
    if let Some(proposals) = network {
        let name = format!("tried, {proposals}");
        contenders.push(Contender::new(name, "tried-network", tried(proposals)));
    }
    contenders
}
