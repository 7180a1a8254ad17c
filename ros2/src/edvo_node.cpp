// SPDX-License-Identifier: MIT
// The ROS 2 node: messages in and out of edvo::ros::Tracking, nothing else.
#include "edvo/core/error.hpp"
#include "logic/tracking.hpp"

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2/exceptions.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <memory>
#include <string>
#include <utility>

namespace edvo::ros {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using std_srvs::srv::Trigger;

std::int64_t nanoseconds(const builtin_interfaces::msg::Time& stamp) {
  return std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec;
}

ImageMessage from_ros(const Image& image) {
  return {.stamp_ns = nanoseconds(image.header.stamp),
          .encoding = image.encoding,
          .width = static_cast<int>(image.width),
          .height = static_cast<int>(image.height),
          .step = static_cast<int>(image.step),
          .is_bigendian = image.is_bigendian != 0,
          .data = image.data};
}

SE3 from_ros(const geometry_msgs::msg::Transform& transform) {
  const auto& q = transform.rotation;
  const auto& t = transform.translation;
  return {.rotation = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized(),
          .translation = {t.x, t.y, t.z}};
}

template <typename Rotation>
void set_rotation(const SE3& pose, Rotation& rotation) {
  rotation.w = pose.rotation.w();
  rotation.x = pose.rotation.x();
  rotation.y = pose.rotation.y();
  rotation.z = pose.rotation.z();
}

template <typename Point>
void set_position(const SE3& pose, Point& point) {
  point.x = pose.translation.x();
  point.y = pose.translation.y();
  point.z = pose.translation.z();
}

class EdvoNode final : public rclcpp::Node {
 public:
  EdvoNode()
      : Node("edvo"),
        odom_frame_(declare_parameter<std::string>("odom_frame", "odom")),
        map_frame_(declare_parameter<std::string>("map_frame", "map")),
        base_frame_(declare_parameter<std::string>("base_frame", "base_link")),
        map_file_(declare_parameter<std::string>("map_file", "edvo.map")),
        publish_tf_(declare_parameter<bool>("publish_tf", true)),
        tracking_(TrackingOptions{
            .units_per_metre = declare_parameter<double>("units_per_metre", 1000.0),
            .sync_tolerance = declare_parameter<double>("sync_tolerance", 0.02),
            .queue = static_cast<int>(declare_parameter<int>("queue", 10))}),
        buffer_(get_clock()),
        listener_(buffer_),
        broadcaster_(*this) {
    const auto qos = rclcpp::SensorDataQoS();
    odometry_ = create_publisher<nav_msgs::msg::Odometry>("odom", 10);
    info_ = create_subscription<CameraInfo>(
        "camera_info", qos, [this](const CameraInfo& message) { set_camera(message); });
    colour_ = create_subscription<Image>("image", qos, [this](const Image& message) {
      publish(tracking_.add_colour(from_ros(message)));
    });
    depth_ = create_subscription<Image>("depth", qos, [this](const Image& message) {
      publish(tracking_.add_depth(from_ros(message)));
    });
    reset_ = create_service<Trigger>(
        "~/reset", [this](const Trigger::Request::SharedPtr, Trigger::Response::SharedPtr answer) {
          tracking_.reset();
          refused_ = restarts_ = 0;  // as the status
          answer->success = true;
        });
    save_ = create_service<Trigger>(
        "~/save_map",
        [this](const Trigger::Request::SharedPtr, Trigger::Response::SharedPtr answer) {
          save_map(*answer);
        });
  }

 private:
  // Waits for the mounting of the camera, unless the image is in the base's frame.
  void set_camera(const CameraInfo& message) {
    if (tracking_.has_camera()) return;
    try {
      const auto mounted =
          buffer_.lookupTransform(base_frame_, message.header.frame_id, tf2::TimePointZero);
      tracking_.set_base_from_optical(from_ros(mounted.transform));
      tracking_.set_camera(to_camera(static_cast<int>(message.width),
                                     static_cast<int>(message.height), message.k,
                                     message.distortion_model, message.d));
    } catch (const tf2::TransformException& error) {
      RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 5000, "no transform to the camera yet: %s",
                           error.what());
    } catch (const Error& error) {
      RCLCPP_ERROR_THROTTLE(get_logger(), *get_clock(), 5000, "%s", error.what());
    }
  }

  void publish(const std::optional<TrackingOutput>& output) {
    const TrackingStatus& status = tracking_.status();
    if (status.refused > refused_)
      RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 5000, "%s", status.last_problem.c_str());
    refused_ = status.refused;
    if (status.restarts > restarts_)
      RCLCPP_WARN(get_logger(),
                  "the clock jumped back by %.1f s: odom begins anew at the origin, and what was "
                  "seen before is not in the map",
                  status.last_jump);
    restarts_ = status.restarts;
    if (!output) return;
    if (!output->has_pose) {
      RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 1000, "lost: %s",
                           std::string(name_of(output->result.loss_cause)).c_str());
      return;
    }
    const rclcpp::Time stamp(output->stamp_ns);
    nav_msgs::msg::Odometry message;
    message.header.stamp = stamp;
    message.header.frame_id = odom_frame_;
    message.child_frame_id = base_frame_;
    set_position(output->odom_from_base, message.pose.pose.position);
    set_rotation(output->odom_from_base, message.pose.pose.orientation);
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column)
        message.pose.covariance[static_cast<std::size_t>(6 * row + column)] =
            output->covariance(row, column);
    message.twist.covariance[0] = -1;  // no twist is estimated
    odometry_->publish(message);
    if (!publish_tf_) return;
    send(stamp, odom_frame_, base_frame_, output->odom_from_base);
    send(stamp, map_frame_, odom_frame_, output->map_from_odom);
  }

  void send(const rclcpp::Time& stamp, const std::string& parent, const std::string& child,
            const SE3& parent_from_child) {
    geometry_msgs::msg::TransformStamped message;
    message.header.stamp = stamp;
    message.header.frame_id = parent;
    message.child_frame_id = child;
    set_position(parent_from_child, message.transform.translation);
    set_rotation(parent_from_child, message.transform.rotation);
    broadcaster_.sendTransform(message);
  }

  void save_map(Trigger::Response& answer) {
    try {
      tracking_.save_map(map_file_);
      answer.success = true;
      answer.message = map_file_;
    } catch (const Error& error) {
      answer.success = false;
      answer.message = error.what();
    }
  }

  std::string odom_frame_, map_frame_, base_frame_, map_file_;
  bool publish_tf_;
  Tracking tracking_;
  std::int64_t refused_ = 0, restarts_ = 0;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  tf2_ros::TransformBroadcaster broadcaster_;
  rclcpp::Publisher<nav_msgs::msg::Odometry>::SharedPtr odometry_;
  rclcpp::Subscription<CameraInfo>::SharedPtr info_;
  rclcpp::Subscription<Image>::SharedPtr colour_, depth_;
  rclcpp::Service<Trigger>::SharedPtr reset_, save_;
};

}  // namespace
}  // namespace edvo::ros

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<edvo::ros::EdvoNode>());
  rclcpp::shutdown();
  return 0;
}
