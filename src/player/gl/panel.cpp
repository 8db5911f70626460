#include "player/gl/panel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "player/gl/controls.h"
#include "player/view.h"

namespace prt::gl {
namespace {

constexpr std::size_t kFrames = 120;
constexpr float kGraphHeight = 80.0F;
constexpr std::array kKinds = {"point", "sphere", "spot", "quad", "sun"};
constexpr std::array kShows = {"full", "direct", "indirect", "visibility", "clusters"};
/// Passes and their colours in the graph.
struct PassColour {
  std::string_view pass;
  ImU32 colour;
};
constexpr std::array kPasses = {PassColour{"light", IM_COL32(240, 190, 60, 255)},
                                PassColour{"geometry", IM_COL32(90, 160, 240, 255)},
                                PassColour{"splats", IM_COL32(110, 200, 110, 255)},
                                PassColour{"shade", IM_COL32(220, 100, 100, 255)}};

ImU32 colour_of(std::string_view pass) {
  for (const PassColour& known : kPasses) {
    if (known.pass == pass) return known.colour;
  }
  return IM_COL32(160, 160, 160, 255);
}

/// The last frames as stacked bars, full height at the slowest.
void draw_graph(const std::deque<PassTimes>& frames) {
  double slowest = 1.0;
  for (const PassTimes& frame : frames) slowest = std::max(slowest, total(frame));
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const float bar = width / static_cast<float>(kFrames);
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled(corner, {corner.x + width, corner.y + kGraphHeight}, IM_COL32(0, 0, 0, 120));
  float x = corner.x;
  for (const PassTimes& frame : frames) {
    float y = corner.y + kGraphHeight;
    for (const auto& [pass, ms] : frame) {
      const float height = kGraphHeight * static_cast<float>(ms / slowest);
      draw->AddRectFilled({x, y - height}, {x + bar, y}, colour_of(pass));
      y -= height;
    }
    x += bar;
  }
  ImGui::Dummy({width, kGraphHeight});
  ImGui::Text("%.1f ms at most", slowest);
  for (const PassColour& known : kPasses) {
    double last = 0.0;
    for (const auto& [pass, ms] : frames.back()) last += known.pass == pass ? ms : 0.0;
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(known.colour), "%-9s %6.1f ms",
                       known.pass.data(), last);
  }
}

/// Power is the largest channel; the colour is relative to it.
void edit_intensity(Light& light) {
  float power = std::max(1e-6F, light.intensity.maxCoeff());
  Vec3f colour = light.intensity / power;
  const char* unit = light.kind == Light::Kind::kSun    ? "W/m2"
                     : light.kind == Light::Kind::kQuad ? "W/(m2 sr)"
                                                        : "W/sr";
  const bool powered =
      ImGui::SliderFloat(unit, &power, 0.01F, 1000.0F, "%.2f", ImGuiSliderFlags_Logarithmic);
  const bool coloured = ImGui::ColorEdit3("colour", colour.data(), ImGuiColorEditFlags_Float);
  if (powered || coloured) light.intensity = power * colour;
}

void edit_shape(Light& light, float scene_size) {
  const float step = 0.002F * scene_size;
  if (light.kind != Light::Kind::kSun) ImGui::DragFloat3("place, m", light.position.data(), step);
  if (light.kind == Light::Kind::kSphere) {
    ImGui::DragFloat("radius, m", &light.radius, 0.1F * step, 0.001F, scene_size);
  }
  if (light.kind == Light::Kind::kSpot || light.kind == Light::Kind::kSun) {
    Vec3f direction = light.direction;
    if (ImGui::DragFloat3("direction", direction.data(), 0.01F) && direction.norm() > 1e-3F) {
      light.direction = direction.normalized();
    }
  }
  if (light.kind == Light::Kind::kSpot) {
    ImGui::SliderAngle("inner", &light.inner_angle, 0.0F, 89.0F);
    ImGui::SliderAngle("outer", &light.outer_angle, 1.0F, 90.0F);
    light.inner_angle = std::min(light.inner_angle, light.outer_angle);
  }
  if (light.kind == Light::Kind::kQuad) {
    ImGui::DragFloat3("edge u, m", light.edge_u.data(), 0.1F * step);
    ImGui::DragFloat3("edge v, m", light.edge_v.data(), 0.1F * step);
  }
}

void edit_light(PanelState& state) {
  Light& light = state.stage.lights[state.selected];
  int kind = static_cast<int>(light.kind);
  if (ImGui::Combo("kind", &kind, kKinds.data(), static_cast<int>(kKinds.size()))) {
    light = as_kind(light, static_cast<Light::Kind>(kind), state.scene_size);
  }
  edit_intensity(light);
  edit_shape(light, state.scene_size);
}

void edit_lights(PanelState& state) {
  auto& lights = state.stage.lights;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::RadioButton(std::to_string(i + 1).c_str(), state.selected == i)) state.selected = i;
    ImGui::PopID();
  }
  if (lights.size() < static_cast<std::size_t>(kMostLights) && ImGui::Button("add")) {
    Light another = lights.empty() ? Light{} : lights[state.selected];
    another.position.x() += 0.05F * state.scene_size;
    lights.push_back(another);
    state.selected = lights.size() - 1;
  }
  ImGui::SameLine();
  if (!lights.empty() && ImGui::Button("remove")) {
    lights.erase(lights.begin() + static_cast<std::ptrdiff_t>(state.selected));
    state.selected = std::min(state.selected, std::max<std::size_t>(1, lights.size()) - 1);
  }
  if (!lights.empty()) edit_light(state);
}

void edit_picture(PanelState& state) {
  int show = static_cast<int>(state.show);
  if (ImGui::Combo("show", &show, kShows.data(), static_cast<int>(kShows.size()))) {
    state.show = static_cast<Show>(show);
  }
  ImGui::SliderFloat("exposure", &state.stage.exposure, 1e-3F, 1e3F, "%.3f",
                     ImGuiSliderFlags_Logarithmic);
  if (ImGui::Button("own exposure")) state.auto_exposure = true;
  ImGui::Checkbox("walk", &state.walking);
  ImGui::SameLine();
  ImGui::Checkbox("stereo", &state.stereo.on);
  if (state.stereo.on) {
    ImGui::SliderFloat("eyes, m", &state.stereo.eye_distance, 0.0F, 0.2F, "%.3f");
  }
  if (ImGui::Button("screenshot (P)")) state.screenshot = true;
  ImGui::SameLine();
  if (ImGui::Button("turntable (T)")) state.turntable = true;
}

void edit_environment(Stage& stage) {
  stage.turn = std::remainder(stage.turn, 360.0F);
  ImGui::SliderFloat("sky turns, deg", &stage.turn, -180.0F, 180.0F, "%.0f");
  ImGui::SliderFloat("mirrored", &stage.reflection, 0.0F, 1.0F, "%.2f");
}

/// Rings where the lights are, the selected one's brighter.
void mark_lights(const PanelState& state) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const View view(state.stage.camera, static_cast<int>(size.x), static_cast<int>(size.y));
  for (std::size_t i = 0; i < state.stage.lights.size(); ++i) {
    const Light& light = state.stage.lights[i];
    const Projected at = view.project(light.position);
    if (light.kind == Light::Kind::kSun || !(at.w > 0.0)) continue;
    const ImVec2 centre(0.5F * size.x * static_cast<float>(1.0 + at.x / at.w / view.aspect()),
                        0.5F * size.y * static_cast<float>(1.0 + at.y / at.w));
    const bool selected = i == state.selected;
    ImGui::GetBackgroundDrawList()->AddCircle(
        centre, selected ? 9.0F : 6.0F, IM_COL32(255, 220, 90, selected ? 255 : 140), 0, 2.0F);
  }
}

}  // namespace

double total(const PassTimes& times) {
  double sum = 0.0;
  for (const auto& time : times) sum += time.second;
  return sum;
}

void add_frame(PanelState& state, PassTimes times) {
  state.frames.push_back(std::move(times));
  if (state.frames.size() > kFrames) state.frames.pop_front();
}

void draw_panel(PanelState& state) {
  if (!state.visible) return;
  if (!state.stereo.on && ImGui::GetIO().DisplaySize.y > 0.0F) mark_lights(state);
  ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({310, 520}, ImGuiCond_FirstUseEver);
  ImGui::Begin("prt_play (F1)");
  ImGui::PushItemWidth(-100.0F);
  edit_picture(state);
  if (state.has_lights && ImGui::CollapsingHeader("Lights", ImGuiTreeNodeFlags_DefaultOpen)) {
    edit_lights(state);
  }
  if (state.has_environment &&
      ImGui::CollapsingHeader("Environment", ImGuiTreeNodeFlags_DefaultOpen)) {
    edit_environment(state.stage);
  }
  const bool graph = ImGui::CollapsingHeader("Frame time", ImGuiTreeNodeFlags_DefaultOpen);
  if (graph && !state.frames.empty()) draw_graph(state.frames);
  ImGui::PopItemWidth();
  ImGui::End();
}

}  // namespace prt::gl
