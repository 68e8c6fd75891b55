//! The types of `ros/ppnpack_msgs` as hiroz makes them of its interface files, and processes of
//! ppnpack to talk to.

pub mod process;

#[allow(missing_docs, clippy::all, unexpected_cfgs)]
mod generated {
    include!(concat!(env!("OUT_DIR"), "/generated.rs"));
}

// The generated code looks for it at the root of its crate.
use hiroz_msgs::size_estimation;

pub use generated::ros::ppnpack_msgs;
