// Small task graphs for tests of the coordinator.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "jobs/coordinator.h"

namespace prt::test {

inline TaskSpec make_task(std::string id, std::vector<std::string> inputs = {}, double cost = 1.0,
                          std::string place = {}) {
  TaskSpec task;
  task.kind = id.substr(0, id.find('/'));
  task.parameters = {{"name", id}};
  task.id = std::move(id);
  task.inputs = std::move(inputs);
  task.cost = cost;
  task.place = std::move(place);
  return task;
}

/// What a pure task gives: a function of its key.
inline Digest content_of(const Digest& key) { return hash_text("content of " + key.hex()); }

inline TaskDone done(WorkerId worker, const Assignment& a, bool adopted = false) {
  return {worker, a.task.id, a.key, content_of(a.key), adopted, {}, {}};
}

template <typename T>
std::vector<T> only(const std::vector<Command>& commands) {
  std::vector<T> found;
  for (const Command& command : commands) {
    if (const auto* c = std::get_if<T>(&command)) found.push_back(*c);
  }
  return found;
}

}  // namespace prt::test
