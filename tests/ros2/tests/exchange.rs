//! A node of hiroz and the cells: topics, services and the action, over real processes.

use std::time::Duration;

use hiroz::context::{ZContext, ZContextBuilder};
use hiroz::node::ZNode;
use hiroz::qos::{QosDurability, QosHistory, QosProfile, QosReliability};
use hiroz::{Builder, Result};
use hiroz_msgs::ros::std_srvs;
use hiroz_msgs::ros::tf2_msgs::TFMessage;
use ppnpack_ros2_tests::ppnpack_msgs::{
    AnnounceRequest, Announcement, BeginRequest, CellState, HoldRequest, Session, srv,
};
use ppnpack_ros2_tests::process;
use tokio::time::timeout;

/// The maximum time to wait: far more than anything here takes.
const PATIENCE: Duration = Duration::from_secs(90);

/// The end of a session that packed all: `ppnpack_msgs/Session`.
const ALL_PACKED: u8 = 1;

/// The state of a packed item: `ppnpack_msgs/Item`.
const PACKED: u8 = 3;

/// A node of hiroz in a domain, on the router at this endpoint.
fn node(endpoint: &str, domain: usize) -> Result<(ZContext, ZNode)> {
    let context = ZContextBuilder::default()
        .with_domain_id(domain)
        .with_router_endpoint(endpoint)?
        .disable_multicast_scouting()
        .build()?;
    let node = context.create_node("controller").build()?;
    Ok((context, node))
}

/// The profile of a topic whose last message holds until the next.
fn latched() -> QosProfile {
    QosProfile {
        reliability: QosReliability::Reliable,
        durability: QosDurability::TransientLocal,
        history: QosHistory::from_depth(1),
        ..QosProfile::default()
    }
}

fn items(objects: &[&str]) -> AnnounceRequest {
    let items = objects
        .iter()
        .enumerate()
        .map(|(index, object)| Announcement {
            item_id: format!("item-{index}"),
            object: (*object).to_owned(),
            ..Announcement::default()
        });
    AnnounceRequest {
        items: items.collect(),
    }
}

/// Begins a session that packs by itself.
async fn begin(node: &ZNode) -> Result<()> {
    let begin = node
        .create_client::<srv::Begin>("/ppnpack/cell_1/begin")
        .build()?;
    let request = BeginRequest {
        session_id: "own".to_owned(),
        is_automatic: true,
        ..BeginRequest::default()
    };
    let response = begin.call_with_timeout(&request, PATIENCE).await?;
    assert!(response.success, "{}", response.message);
    Ok(())
}

/// Awaits something, and fails where it does not come.
async fn soon<T>(what: &str, of: impl Future<Output = T>) -> T {
    timeout(PATIENCE, of)
        .await
        .unwrap_or_else(|_| panic!("{what} does not come"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_packing_is_asked_for_followed_and_seen() -> Result<()> {
    let (_stack, endpoint) = process::up(&["--ros", "7"]);
    let (context, node) = node(&endpoint, 7)?;
    let sessions = node
        .create_sub::<Session>("/ppnpack/cell_1/session")
        .with_qos(latched())
        .build()?;
    soon("the session", sessions.async_recv()).await?;
    begin(&node).await?;
    let announce = node
        .create_client::<srv::Announce>("/ppnpack/cell_1/announce")
        .build()?;
    let request = items(&["mug", "bowl", "banana"]);
    let response = announce.call_with_timeout(&request, PATIENCE).await?;
    assert!(response.success, "{}", response.message);
    let end = async {
        loop {
            let session = sessions.async_recv().await?;
            if session.session_id == "own" && session.end != 0 {
                return Result::Ok(session);
            }
        }
    };
    let session = soon("the end", end).await?;
    assert_eq!(session.end, ALL_PACKED, "{}", session.failure);
    assert!(session.items.iter().all(|item| item.state == PACKED));

    // Whoever comes later is given what is so.
    let states = node
        .create_sub::<CellState>("/ppnpack/cell_1/state")
        .with_qos(latched())
        .build()?;
    let state = soon("the state", states.async_recv()).await?;
    assert_eq!(state.bodies.len(), 3);
    let frames = node
        .create_sub::<TFMessage>("/tf_static")
        .with_qos(latched())
        .build()?;
    let fixed = soon("fixed frames", frames.async_recv()).await?;
    let container = &fixed.transforms[0];
    assert_eq!(container.header.frame_id, "world");
    assert_eq!(container.child_frame_id, "cell-1/container");

    let names = context.graph().get_topic_names_and_types();
    for (name, of) in [
        (
            "/ppnpack/cell_1/state",
            "ppnpack_msgs::msg::dds_::CellState_",
        ),
        ("/tf", "tf2_msgs::msg::dds_::TFMessage_"),
    ] {
        let mut found = names.iter().filter(|(topic, _)| topic == name);
        assert!(found.any(|(_, found)| found == of), "{name}: {names:?}");
    }
    let nodes = context.graph().get_node_names();
    assert!(nodes.iter().any(|(name, _)| name == "ppnpack"), "{nodes:?}");
    Ok(())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cell_is_held_and_resumed() -> Result<()> {
    let (_stack, endpoint) = process::up(&["--ros"]);
    let (_context, node) = node(&endpoint, 0)?;
    let states = node
        .create_sub::<CellState>("/ppnpack/cell_1/state")
        .with_qos(latched())
        .build()?;
    soon("a state", states.async_recv()).await?;
    let hold = node
        .create_client::<srv::Hold>("/ppnpack/cell_1/hold")
        .build()?;
    let request = HoldRequest {
        reason: "a door is open".to_owned(),
        is_aborting: false,
    };
    let response = hold.call_with_timeout(&request, PATIENCE).await?;
    assert!(response.success, "{}", response.message);
    let held = async {
        loop {
            let state = states.async_recv().await?;
            if state.is_held {
                return Result::Ok(state);
            }
        }
    };
    assert_eq!(
        soon("that it is held", held).await?.hold_reason,
        "a door is open"
    );
    let resume = node
        .create_client::<std_srvs::srv::Trigger>("/ppnpack/cell_1/resume")
        .build()?;
    let response = resume
        .call_with_timeout(&std_srvs::TriggerRequest::default(), PATIENCE)
        .await?;
    assert!(response.success, "{}", response.message);
    Ok(())
}
