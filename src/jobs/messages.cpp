#include "jobs/messages.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace prt {

using nlohmann::json;

namespace {

Digest digest_at(const json& j, const char* name) {
  return Digest::from_hex(j.at(name).get_ref<const std::string&>());
}

/// As JSON writes it; most ids need no escaping, and a bake has millions of them.
void append_quoted(std::string& text, const std::string& value) {
  const auto is_plain = [](char c) { return c >= ' ' && c < 127 && c != '"' && c != '\\'; };
  if (std::all_of(value.begin(), value.end(), is_plain)) {
    text.append("\"").append(value).append("\"");
  } else {
    text += json(value).dump();
  }
}

/// The task's inputs are named once, by the assignment.
json encode(const TaskSpec& task) {
  return {{"id", task.id},
          {"kind", task.kind},
          {"version", task.version},
          {"parameters", task.parameters},
          {"scene_parts", task.scene_parts},
          {"cost", task.cost}};
}

/// Inputs are written as text right away: as JSON values each costs ten allocations, and the
/// coordinator sends little else.
std::string encode(const Assignment& a) {
  json j = {{"type", "assign"}, {"task", encode(a.task)}, {"key", a.key.hex()}};
  if (a.expected) j["expected"] = a.expected->hex();
  std::string text = j.dump();
  text.pop_back();
  text += ",\"inputs\":[";
  const char* opening = "[";
  for (const TaskInput& in : a.inputs) {
    text += std::exchange(opening, ",[");
    append_quoted(text, in.id);
    text += ',';
    append_quoted(text, in.stage);
    text.append(",\"").append(in.key.hex()).append("\",\"").append(in.content.hex()).append("\"]");
  }
  return text + "]}";
}

Assignment decode_assignment(const json& j) {
  Assignment a;
  const json& task = j.at("task");
  a.task.id = task.at("id");
  a.task.kind = task.at("kind");
  a.task.version = task.at("version");
  a.task.parameters = task.at("parameters");
  a.task.scene_parts = task.at("scene_parts");
  a.task.cost = task.at("cost");
  a.key = digest_at(j, "key");
  if (j.contains("expected")) a.expected = digest_at(j, "expected");
  for (const json& in : j.at("inputs")) {
    a.inputs.push_back({in.at(0), in.at(1), Digest::from_hex(in.at(2).get<std::string>()),
                        Digest::from_hex(in.at(3).get<std::string>())});
    a.task.inputs.push_back(a.inputs.back().id);
  }
  return a;
}

json encode(const WorkerJoined& e) {
  return {{"type", "joined"}, {"worker", e.worker}, {"slots", e.slots}};
}

json encode(const TaskDone& e) {
  return {
      {"type", "done"},        {"worker", e.worker},         {"task", e.task},
      {"key", e.key.hex()},    {"content", e.content.hex()}, {"adopted", e.adopted},
      {"began", e.cost.began}, {"seconds", e.cost.seconds},  {"cpu_seconds", e.cost.cpu_seconds},
      {"bytes", e.cost.bytes}, {"slot", e.cost.slot},        {"figures", e.figures}};
}

json encode(const TaskFailed& e) {
  return {{"type", "failed"},
          {"worker", e.worker},
          {"task", e.task},
          {"message", e.message},
          {"user_error", e.user_error}};
}

json encode(const InputUnsound& e) {
  return {{"type", "unsound"}, {"worker", e.worker}, {"task", e.task}, {"input", e.input}};
}

json encode(const Heartbeat& e) { return {{"type", "alive"}, {"worker", e.worker}}; }

json encode(const StopRequested& e) {
  return {{"type", "stop"}, {"code", static_cast<int>(e.code)}};
}

json encode(const DrainRequested&) { return {{"type", "drain"}}; }

template <typename T>
json encode(const T&) {
  throw std::logic_error("an event that never travels");
}

TaskDone decode_done(const json& j) {
  return {j.at("worker"),
          j.at("task"),
          digest_at(j, "key"),
          digest_at(j, "content"),
          j.at("adopted"),
          {j.at("began"), j.at("seconds"), j.at("cpu_seconds"), j.at("bytes"), j.at("slot")},
          j.at("figures")};
}

Event decode_event(const json& j) {
  const std::string type = j.at("type");
  if (type == "done") return decode_done(j);
  if (type == "joined") return WorkerJoined{j.at("worker"), j.at("slots")};
  if (type == "alive") return Heartbeat{j.at("worker")};
  if (type == "unsound") return InputUnsound{j.at("worker"), j.at("task"), j.at("input")};
  if (type == "stop") return StopRequested{static_cast<ExitCode>(j.at("code").get<int>())};
  if (type == "drain") return DrainRequested{};
  if (type == "failed") {
    return TaskFailed{j.at("worker"), j.at("task"), j.at("message"), j.at("user_error")};
  }
  throw UnsoundData("message of unknown type '" + type + "'");
}

Order decode(const json& j) {
  const std::string type = j.at("type");
  if (type == "assign") return decode_assignment(j);
  if (type == "here") return StillHere{};
  if (type == "dismiss") return Dismissed{static_cast<ExitCode>(j.at("code").get<int>())};
  throw UnsoundData("message of unknown type '" + type + "'");
}

json parse(const std::string& text) {
  json j = json::parse(text, nullptr, false);
  if (!j.is_object()) throw UnsoundData("a message is not a JSON object");
  return j;
}

}  // namespace

std::string encode_order(const Order& order) {
  if (const auto* dismissed = std::get_if<Dismissed>(&order)) {
    return json{{"type", "dismiss"}, {"code", static_cast<int>(dismissed->code)}}.dump();
  }
  if (std::holds_alternative<StillHere>(order)) return json{{"type", "here"}}.dump();
  return encode(std::get<Assignment>(order));
}

Order decode_order(const std::string& text) {
  try {
    return decode(parse(text));
  } catch (const json::exception& e) {
    throw UnsoundData(std::string("malformed message: ") + e.what());
  }
}

std::string encode_report(const Event& event) {
  // A message may quote a file name that is no UTF-8.
  return std::visit([](const auto& e) { return encode(e); }, event)
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

Event decode_report(const std::string& text) {
  try {
    return decode_event(parse(text));
  } catch (const json::exception& e) {
    throw UnsoundData(std::string("malformed message: ") + e.what());
  }
}

}  // namespace prt
