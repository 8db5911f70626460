#include "scene/gltf_lights.h"

#include <tiny_gltf.h>

#include <Eigen/Geometry>

#include "base/log.h"

namespace prt::gltf {
namespace {

/// Luminous efficacy at 555 nm: glTF's candela and lux to W/sr and W/m².
constexpr double kLumensPerWatt = 683.0;

/// A node's direction in the world, from one along an axis of its own.
Vec3f world_direction(const WorldNode& node, const Eigen::Vector3d& local, const Vec3f& fallback) {
  const Eigen::Vector3d direction = node.linear() * local;
  if (!direction.allFinite() || !(direction.stableNorm() > 0.0)) return fallback;
  return direction.stableNormalized().cast<float>();
}

Vec3f world_position(const WorldNode& node) {
  Vec3f position = node.to_world.topRightCorner<3, 1>().cast<float>();
  if (!position.allFinite()) node.json.fail("its position is not finite");
  return position;
}

SceneLight read_light(const tinygltf::Light& from, const WorldNode& node) {
  SceneLight light;
  light.name = from.name;
  if (from.type == "directional") light.kind = SceneLight::Kind::kSun;
  if (from.type == "spot") {
    light.kind = SceneLight::Kind::kSpot;
    light.inner_angle = static_cast<float>(from.spot.innerConeAngle);
    light.outer_angle = static_cast<float>(from.spot.outerConeAngle);
  }
  Eigen::Vector3d colour = Eigen::Vector3d::Ones();
  if (!from.color.empty()) colour = Eigen::Map<const Eigen::Vector3d>(from.color.data());
  light.intensity = (from.intensity / kLumensPerWatt * colour).cast<float>();
  if (!light.intensity.allFinite()) node.json.fail("the intensity of its light is not finite");
  light.position = world_position(node);
  light.direction = world_direction(node, -Eigen::Vector3d::UnitZ(), -Vec3f::UnitZ());
  return light;
}

SceneCamera read_camera(const tinygltf::Camera& from, const WorldNode& node) {
  SceneCamera camera;
  camera.eye = world_position(node);
  camera.target = camera.eye + world_direction(node, -Eigen::Vector3d::UnitZ(), -Vec3f::UnitZ());
  camera.up = world_direction(node, Eigen::Vector3d::UnitY(), Vec3f::UnitY());
  if (from.type == "perspective") camera.vertical_fov = static_cast<float>(from.perspective.yfov);
  return camera;
}

}  // namespace

void load_lights_and_camera(const Document& document, const std::vector<WorldNode>& nodes,
                            Scene& scene) {
  const tinygltf::Model& model = document.model();
  for (const WorldNode& node : nodes) {
    if (node.node->camera >= 0 && !scene.camera) {
      scene.camera = read_camera(model.cameras[static_cast<std::size_t>(node.node->camera)], node);
    }
    const auto holder = node.node->extensions.find("KHR_lights_punctual");
    if (holder == node.node->extensions.end()) continue;
    const int index = holder->second.Get("light").GetNumberAsInt();
    scene.lights.push_back(read_light(model.lights[static_cast<std::size_t>(index)], node));
  }
  if (!scene.lights.empty()) {
    log::info("{}: {} {}; candela and lux divided by {} lm/W", document.name(), scene.lights.size(),
              scene.lights.size() == 1 ? "light" : "lights", kLumensPerWatt);
  }
}

}  // namespace prt::gltf
