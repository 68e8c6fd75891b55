//! The hashes of types, held against those that ROS 2 publishes.
#![allow(missing_docs)]

use ppnpack_ros::description::{Message, TypeHash};
use ppnpack_ros::messages::action_msgs::{CancelGoal, GoalStatusArray};
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::sensor_msgs::PointCloud2;
use ppnpack_ros::messages::std_msgs::Text;
use ppnpack_ros::messages::std_srvs::{SetBool, Trigger};
use ppnpack_ros::messages::tf2_msgs::TfMessage;
use ppnpack_ros::messages::visualization_msgs::MarkerArray;
use ppnpack_ros::service::Service;

fn message<M: Message>() -> String {
    TypeHash::of_message::<M>().to_string()
}

fn service<S: Service>() -> String {
    TypeHash::of_service::<S>().to_string()
}

#[test]
fn hashes_are_those_of_ros() {
    let cases = [
        (
            message::<Text>(),
            "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
        ),
        (
            message::<Time>(),
            "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
        ),
        (
            message::<PointCloud2>(),
            "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
        ),
        (
            message::<TfMessage>(),
            "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
        ),
        (
            message::<MarkerArray>(),
            "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
        ),
        (
            message::<GoalStatusArray>(),
            "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
        ),
        (
            service::<Trigger>(),
            "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
        ),
        (
            service::<SetBool>(),
            "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
        ),
        (
            service::<CancelGoal>(),
            "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
        ),
    ];
    for (hash, expected) in cases {
        assert_eq!(hash, format!("RIHS01_{expected}"));
    }
}
