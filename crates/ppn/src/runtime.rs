//! libtorch itself: its version and devices.

use ppnpack_model::settings::Device;

use crate::error::NetworkError;

/// Version of libtorch that this is built for.
pub const LIBTORCH_VERSION: &str = "2.11.0";

/// Gives the device asked for.
pub(crate) fn device(device: Device) -> Result<tch::Device, NetworkError> {
    match device {
        Device::Cpu => Ok(tch::Device::Cpu),
        Device::Cuda if tch::Cuda::is_available() => Ok(tch::Device::Cuda(0)),
        Device::Cuda => Err(NetworkError::Other(
            "there is no CUDA device that libtorch can use: run on the cpu, or name a full installation of torch 2.11 with \
             PPNPACK_TORCH"
                .to_owned(),
        )),
    }
}

/// Keeps libtorch to one thread in what the calling thread asks of it: two on busy cores stall each
/// other.
pub(crate) fn use_one_thread() {
    tch::set_num_threads(1);
}
