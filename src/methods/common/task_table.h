// A method whose tasks are a table from kinds to functions.
#pragma once

#include <map>
#include <string>

#include "methods/method.h"

namespace prt {

struct TaskKind {
  Artifact (*run)(const TaskSpec&, const TaskReader&);
  const char* equation;  ///< as Method::equation
};
using TaskTable = std::map<std::string, TaskKind>;

/// The kinds of sampling and rays, to which a method adds its own.
TaskTable sampling_and_rays_tasks();

class TableMethod : public Method {
 public:
  [[nodiscard]] std::vector<std::string> kinds() const override;
  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader) const override;
  [[nodiscard]] std::string equation(const std::string& kind) const override;

 protected:
  [[nodiscard]] virtual const TaskTable& tasks() const = 0;
};

}  // namespace prt
