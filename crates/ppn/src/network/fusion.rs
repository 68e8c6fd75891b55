//! Fusion of the features of the container and of the items.

use tch::{TchError, Tensor};

use ppnpack_model::architecture::Fusion;

/// Brings features of one resolution together.
///
/// `container` is `[S, C, X, Y]`, `items` is `[S, V, C, K, K]` with the footprint's centre at `K /
/// 2`; the result is `[C', S V, X, Y]`, where a cell stands for the footprint's centre.
pub(crate) fn fuse(fusion: Fusion, container: &Tensor, items: &Tensor) -> Result<Tensor, TchError> {
    match fusion {
        Fusion::Correlation => correlate(container, items),
        Fusion::Concatenation => concatenate(container, items),
    }
}

/// Counts the channels that fusing `width` channels gives.
pub(super) fn fused_width(fusion: Fusion, width: i64) -> i64 {
    match fusion {
        Fusion::Correlation => width,
        Fusion::Concatenation => 2 * width,
    }
}

/// Cross-correlation per channel: `C(x) = sum_u H(x + u) K(u)`, with zeros around the container.
fn correlate(container: &Tensor, items: &Tensor) -> Result<Tensor, TchError> {
    let (steps, channels, nx, ny) = container.size4()?;
    let (_, views, _, side, _) = items.size5()?;
    let (before, after) = (side / 2, side - 1 - side / 2);
    let padded = container.f_constant_pad_nd([before, after, before, after])?;
    // All windows that the kernels look through; a strided copy, several times as fast as
    // libtorch's im2col.
    let windows = padded.f_unfold(2, side, 1)?.f_unfold(3, side, 1)?;
    let windows = windows.f_permute([0, 1, 4, 5, 2, 3])?;
    let windows = windows.f_reshape([steps * channels, side * side, nx * ny])?;
    let kernels = items.f_permute([0, 2, 1, 3, 4])?;
    let kernels = kernels.f_reshape([steps * channels, views, side * side])?;
    let correlated = kernels.f_bmm(&windows)?;
    let correlated = correlated.f_view([steps, channels, views, nx, ny])?;
    let by_channel = correlated.f_permute([1, 0, 2, 3, 4])?;
    by_channel.f_reshape([channels, steps * views, nx, ny])
}

/// The item's features beside the container's, the footprint's centre on the container's.
fn concatenate(container: &Tensor, items: &Tensor) -> Result<Tensor, TchError> {
    let (steps, channels, nx, ny) = container.size4()?;
    let (_, views, _, side, _) = items.size5()?;
    let around = |cells: i64| {
        let before = cells / 2 - side / 2;
        [before, cells - side - before]
    };
    let ([left, right], [above, below]) = (around(ny), around(nx));
    // Negative padding crops.
    let items = items.f_constant_pad_nd([left, right, above, below])?;
    let container = container.f_unsqueeze(1)?;
    let container = container.f_expand([steps, views, channels, nx, ny], false)?;
    let both = Tensor::f_cat(&[container, items], 2)?;
    let by_channel = both.f_permute([2, 0, 1, 3, 4])?;
    by_channel.f_reshape([2 * channels, steps * views, nx, ny])
}
