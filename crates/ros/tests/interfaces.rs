//! The interface files of `ros/ppnpack_msgs` say what the structs are: ROS makes its types of the ones, and this of the others.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ppnpack_ros::description::{Message, Types};
use ppnpack_ros::messages::ppnpack_actions::{PackFeedback, PackGoal, PackResult};
use ppnpack_ros::messages::ppnpack_msgs::{
    Announcement, Body, CellState, Decision, Item, Outcome, Session,
};
use ppnpack_ros::messages::ppnpack_srvs::{Announce, Begin, Changed, Hold, Plan, Report, Withdraw};
use ppnpack_ros::service::Service;

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ros/ppnpack_msgs")
}

/// The fields of each part of an interface file, as it writes them.
fn file(name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(package().join(name)).unwrap();
    let parts = text.split("---\n").map(|part| {
        let lines = part.lines().map(str::trim);
        let fields =
            lines.filter(|line| !line.is_empty() && !line.starts_with('#') && !line.contains('='));
        fields.map(str::to_owned).collect()
    });
    parts.collect()
}

/// The fields of a struct, as an interface file of the package writes them.
fn fields<M: Message>() -> Vec<String> {
    let fields = M::fields(&mut Types::default());
    let fields = fields
        .iter()
        .map(|field| field.to_string().replace("ppnpack_msgs/", ""));
    let fields = fields.filter(|field| field != "uint8 structure_needs_at_least_one_member");
    fields.collect()
}

fn check_message<M: Message>(name: &str) -> String {
    assert_eq!(M::type_name(), format!("ppnpack_msgs/msg/{name}"));
    let path = format!("msg/{name}.msg");
    assert_eq!(file(&path), [fields::<M>()], "{path}");
    path
}

fn check_service<S: Service>(name: &str) -> String {
    assert_eq!(S::type_name(), format!("ppnpack_msgs/srv/{name}"));
    let path = format!("srv/{name}.srv");
    let parts = [fields::<S::Request>(), fields::<S::Response>()];
    assert_eq!(file(&path), parts, "{path}");
    path
}

fn check_action() -> String {
    let path = "action/Pack.action".to_owned();
    let parts = [
        fields::<PackGoal>(),
        fields::<PackResult>(),
        fields::<PackFeedback>(),
    ];
    assert_eq!(file(&path), parts);
    path
}

#[test]
fn interface_files_and_structs_agree() {
    let checked = BTreeSet::from([
        check_message::<Announcement>("Announcement"),
        check_message::<Body>("Body"),
        check_message::<CellState>("CellState"),
        check_message::<Decision>("Decision"),
        check_message::<Item>("Item"),
        check_message::<Outcome>("Outcome"),
        check_message::<Session>("Session"),
        check_service::<Announce>("Announce"),
        check_service::<Begin>("Begin"),
        check_service::<Changed>("Changed"),
        check_service::<Hold>("Hold"),
        check_service::<Plan>("Plan"),
        check_service::<Report>("Report"),
        check_service::<Withdraw>("Withdraw"),
        check_action(),
    ]);
    let text = std::fs::read_to_string(package().join("CMakeLists.txt")).unwrap();
    let listed = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix('"'));
    let listed: BTreeSet<String> = listed
        .map(|line| line.trim_end_matches('"').to_owned())
        .collect();
    assert_eq!(listed, checked, "what colcon builds");
    let files = ["msg", "srv", "action"].into_iter().flat_map(|folder| {
        let entries = std::fs::read_dir(package().join(folder)).unwrap();
        entries.map(move |entry| format!("{folder}/{}", entry.unwrap().file_name().display()))
    });
    assert_eq!(files.collect::<BTreeSet<_>>(), checked, "what there is");
}
