#include "methods/common/task_table.h"

#include "methods/common/rays.h"
#include "methods/common/sampling.h"

namespace prt {

TaskTable sampling_and_rays_tasks() {
  TaskTable table;
  for (const auto& kind : sampling_kinds()) table[kind] = {run_sampling, "LB §4.1"};
  for (const auto& kind : rays_kinds()) table[kind] = {run_rays, "LB §4.2"};
  return table;
}

std::vector<std::string> TableMethod::kinds() const {
  std::vector<std::string> kinds;
  for (const auto& [kind, task] : tasks()) kinds.push_back(kind);
  return kinds;
}

Artifact TableMethod::run(const TaskSpec& task, const TaskReader& reader) const {
  return tasks().at(task.kind).run(task, reader);
}

std::string TableMethod::equation(const std::string& kind) const {
  const auto task = tasks().find(kind);
  return task == tasks().end() ? "" : task->second.equation;
}

}  // namespace prt
