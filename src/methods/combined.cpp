#include "methods/combined.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace prt {
namespace {

constexpr const char* kEverything = "everything";

/// Takes the reconstruct step off a program; the space that it reconstructs.
std::string take_reconstructed(Package& package) {
  const auto last = std::get<ReconstructStep>(package.program.back());
  package.program.pop_back();
  return last.input;
}

template <typename T>
void append(std::vector<T>& all, std::vector<T> more) {
  std::ranges::move(more, std::back_inserter(all));
}

class Combined : public Method {
 public:
  explicit Combined(std::vector<const Method*> methods) : methods_(std::move(methods)) {}

  [[nodiscard]] std::string name() const override {
    std::string all;
    for (const Method* method : methods_) all += (all.empty() ? "" : "+") + method->name();
    return all;
  }

  [[nodiscard]] std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> all;
    for (const Method* method : methods_) append(all, method->options());
    return all;
  }

  [[nodiscard]] Plan plan(const PlanInputs& inputs) const override {
    Plan all;
    all.complete = true;
    std::set<std::string> tasks, results, left_out;
    for (const Method* method : methods_) {
      Plan plan = method->plan(inputs);
      all.complete = all.complete && plan.complete;
      all.plays_lights = all.plays_lights || plan.plays_lights;
      all.plays_environment = all.plays_environment || plan.plays_environment;
      for (TaskSpec& task : plan.tasks) {
        if (tasks.insert(task.id).second) all.tasks.push_back(std::move(task));
      }
      for (std::string& id : plan.results) {
        if (results.insert(id).second) all.results.push_back(std::move(id));
      }
      for (LeftOut& what : plan.left_out) {
        if (left_out.insert(what.what).second) all.left_out.push_back(std::move(what));
      }
    }
    return all;
  }

  [[nodiscard]] int effort_levels() const override {
    int most = 0;
    for (const Method* method : methods_) most = std::max(most, method->effort_levels());
    return most;
  }

  /// Methods without levels do the same at every one.
  [[nodiscard]] OptionValues with_effort(const OptionValues& options, int level) const override {
    OptionValues values = options;
    for (const Method* method : methods_) {
      const int levels = method->effort_levels();
      if (levels > 0) values = method->with_effort(values, std::min(level, levels - 1));
    }
    return values;
  }

  [[nodiscard]] std::vector<std::string> kinds() const override {
    std::set<std::string> all;
    for (const Method* method : methods_) {
      for (const std::string& kind : method->kinds()) all.insert(kind);
    }
    return {all.begin(), all.end()};
  }

  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader) const override {
    const Method* method = method_of(task.kind);
    if (method == nullptr) throw std::logic_error("no method runs tasks of kind " + task.kind);
    return method->run(task, reader);
  }

  [[nodiscard]] std::string equation(const std::string& kind) const override {
    const Method* method = method_of(kind);
    return method == nullptr ? "" : method->equation(kind);
  }

  [[nodiscard]] std::vector<StageWork> work(const BakeSize& size, const OptionValues& options,
                                            const StageFigures& figures) const override {
    std::vector<StageWork> all;
    std::set<std::string> stages;
    for (const Method* method : methods_) {
      for (const StageWork& stage : method->work(size, options, figures)) {
        if (stages.insert(stage.stage).second) all.push_back(stage);
      }
    }
    return all;
  }

  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
      const OptionValues& options) const override {
    Package all = methods_.front()->assemble(result, options);
    for (std::size_t i = 1; i < methods_.size(); ++i) {
      add_part(all, methods_[i]->assemble(result, options));
    }
    all.provenance["method"] = name();
    return all;
  }

 private:
  /// Any that knows the kind, for what two methods share is one piece of code; null if none does.
  [[nodiscard]] const Method* method_of(const std::string& kind) const {
    for (const Method* method : methods_) {
      if (std::ranges::count(method->kinds(), kind) > 0) return method;
    }
    return nullptr;
  }

  std::vector<const Method*> methods_;
};

}  // namespace

std::shared_ptr<const Method> combined(const std::vector<const Method*>& methods) {
  if (methods.size() > 1) return std::make_shared<Combined>(methods);
  return {std::shared_ptr<void>(), methods.at(0)};
}

void add_part(Package& whole, Package part) {
  if (part.program.empty()) return;
  if (!whole.visibility) whole.visibility = std::move(part.visibility);
  const std::size_t known = whole.operators.size() + part.operators.size();
  whole.operators.merge(part.operators);
  if (whole.operators.size() != known) {
    throw std::logic_error("two methods made an operator of one name");
  }
  for (const Space& space : part.spaces) {
    if (std::ranges::count(whole.spaces, space.name, &Space::name) > 0) {
      throw std::logic_error("two methods made the space " + space.name);
    }
  }
  append(whole.spaces, std::move(part.spaces));
  if (whole.program.empty()) {
    whole.program = std::move(part.program);
    return;
  }
  const std::string here = take_reconstructed(whole);
  const std::string there = take_reconstructed(part);
  append(whole.program, std::move(part.program));
  whole.spaces.push_back({kEverything, Space::Kind::kSampleIrradiance,
                          static_cast<std::uint32_t>(whole.samples.size())});
  whole.program.emplace_back(AddStep{here, there, kEverything});
  whole.program.emplace_back(ReconstructStep{kEverything});
}

}  // namespace prt
