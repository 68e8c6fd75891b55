//! Enumerations of the wire, paired with those of the domain.

/// Gives the domain's value for one of the wire.
pub(super) fn read<W: PartialEq, D: Copy>(pairs: &[(W, D)], wire: &W) -> Option<D> {
    let found = pairs.iter().find(|(known, _)| known == wire);
    found.map(|(_, domain)| *domain)
}

/// Gives the wire's value for one of the domain; the unspecified one where it has none.
pub(super) fn write<W: Copy + Default, D: PartialEq>(pairs: &[(W, D)], domain: &D) -> W {
    let found = pairs.iter().find(|(_, known)| known == domain);
    found.map(|(wire, _)| *wire).unwrap_or_default()
}
