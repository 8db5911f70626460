#include "player/gl/window.h"

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "base/error.h"

namespace prt::gl {

struct Window::State {
  GLFWwindow* window = nullptr;
  Input input;
  double x = 0.0, y = 0.0;  // pointer
};

namespace {

Window::State& state_of(GLFWwindow* window);

void on_key(GLFWwindow* window, int key, int /*code*/, int action, int /*mods*/) {
  if (action != GLFW_PRESS || ImGui::GetIO().WantTextInput) return;
  if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
  if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) state_of(window).input.pressed.push_back(key);
  if (key == GLFW_KEY_F1) state_of(window).input.pressed.push_back(kKeyPanel);
}

void on_move(GLFWwindow* window, double x, double y) {
  Window::State& state = state_of(window);
  const Drag moved{static_cast<float>(x - state.x), static_cast<float>(y - state.y)};
  state.x = x;
  state.y = y;
  if (ImGui::GetIO().WantCaptureMouse) return;
  const auto add = [&](int button, Drag& drag) {
    if (glfwGetMouseButton(window, button) != GLFW_PRESS) return;
    drag.x += moved.x;
    drag.y += moved.y;
  };
  add(GLFW_MOUSE_BUTTON_LEFT, state.input.left);
  add(GLFW_MOUSE_BUTTON_RIGHT, state.input.right);
}

void on_scroll(GLFWwindow* window, double /*x*/, double y) {
  if (!ImGui::GetIO().WantCaptureMouse) state_of(window).input.wheel += static_cast<float>(y);
}

bool held(GLFWwindow* window, int key) { return glfwGetKey(window, key) == GLFW_PRESS; }

Vec3f walk_keys(GLFWwindow* window) {
  if (ImGui::GetIO().WantTextInput) return Vec3f::Zero();
  const auto axis = [&](int more, int less) {
    return static_cast<float>(held(window, more)) - static_cast<float>(held(window, less));
  };
  return {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_E, GLFW_KEY_Q), axis(GLFW_KEY_W, GLFW_KEY_S)};
}

GLFWwindow* create(const std::string& title, int width, int height) {
  if (glfwInit() != GLFW_TRUE) {
    throw UserError(
        "--backend gl: no display to open a window on; set DISPLAY, or give --out FILE.png, which "
        "needs none");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (window != nullptr) return window;
  glfwTerminate();
  throw UserError(
      "--backend gl: this display offers no OpenGL 4.3 core; update the driver, or use --backend "
      "cpu");
}

Window::State& state_of(GLFWwindow* window) {
  return *static_cast<Window::State*>(glfwGetWindowUserPointer(window));
}

}  // namespace

Window::Window(const std::string& title, int width, int height)
    : state_(std::make_unique<State>()) {
  GLFWwindow* window = create(title, width, height);
  state_->window = window;
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window, state_.get());
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // nothing is left in the user's folder
  ImGui::StyleColorsDark();
  glfwSetKeyCallback(window, on_key);
  glfwSetCursorPosCallback(window, on_move);
  glfwSetScrollCallback(window, on_scroll);
  glfwGetCursorPos(window, &state_->x, &state_->y);
  ImGui_ImplGlfw_InitForOpenGL(window, true);  // passes events on to the callbacks above
  ImGui_ImplOpenGL3_Init("#version 430 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(state_->window);
  glfwTerminate();
}

bool Window::open() const { return glfwWindowShouldClose(state_->window) == GLFW_FALSE; }

int Window::width() const {
  int width = 0;
  glfwGetFramebufferSize(state_->window, &width, nullptr);
  return width;
}

int Window::height() const {
  int height = 0;
  glfwGetFramebufferSize(state_->window, nullptr, &height);
  return height;
}

Input Window::begin() {
  glfwPollEvents();
  state_->input.walk = walk_keys(state_->window);
  state_->input.shift = held(state_->window, GLFW_KEY_LEFT_SHIFT);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  return std::exchange(state_->input, {});
}

void Window::end() {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width(), height());
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(state_->window);
}

}  // namespace prt::gl
