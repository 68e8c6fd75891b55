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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_but_the_first_try_placements_and_none_is_like_another() {
        let network = ProposalSource::Random { percent: 20.0 };
        let all = contenders(3, 7, Some(network));
        let tries: Vec<bool> = all.iter().map(|one| one.method.trial.is_on()).collect();
        assert_eq!(tries, [false, true, true, true, true]);
        for (index, contender) in all.iter().enumerate() {
            let others = || all.iter().skip(index + 1);
            assert!(others().all(|other| other.key != contender.key));
            assert!(others().all(|other| other.method != contender.method));
            contender.method.validate().unwrap();
            assert_eq!((contender.method.buffer, contender.method.seed), (3, 7));
        }
        assert_eq!(contenders(3, 7, None).len(), 4);
    }
}
