#include "scaling/coordinator_speed.h"

#include <fmt/format.h>

#include <random>
#include <stdexcept>

#include "jobs/coordinator.h"
#include "jobs/messages.h"
#include "scaling/simulation.h"

namespace prt::scaling {

namespace {

std::vector<TaskSpec> layered_graph(std::size_t layers, std::size_t width, std::size_t inputs,
                                    std::mt19937& random) {
  std::vector<TaskSpec> tasks;
  for (std::size_t layer = 0; layer < layers; ++layer) {
    for (std::size_t i = 0; i < width; ++i) {
      TaskSpec& task = tasks.emplace_back();
      task.id = fmt::format("layer{}/{:05}", layer, i);
      task.kind = fmt::format("layer{}", layer);
      task.parameters = {{"cluster", i}, {"rank", 50}};
      task.cost = 1.0 + static_cast<double>(random() % 1000) * 1e-3;
      for (std::size_t k = 0; layer > 0 && k < inputs; ++k) {
        task.inputs.push_back(fmt::format("layer{}/{:05}", layer - 1, (i + k * 7) % width));
      }
    }
  }
  return tasks;
}

class Race {
 public:
  explicit Race(std::vector<TaskSpec> tasks) : coordinator_({}, {}) {
    speed_.tasks = tasks.size();
    for (const TaskSpec& task : tasks) speed_.inputs += task.inputs.size();
    added_ = {std::move(tasks), true};
  }

  CoordinatorSpeed run(int workers, std::mt19937& random) {
    for (int w = 0; w < workers; ++w) feed(WorkerJoined{w, 1});
    feed(added_);
    while (!running_.empty()) {
      std::swap(running_[random() % running_.size()], running_.back());
      const TaskDone done = std::move(running_.back());
      running_.pop_back();
      const std::string text = encode_report(done);
      Event event;
      speed_.messages += timed([&] { event = decode_report(text); });
      feed(event);
    }
    if (coordinator_.undone() > 0) throw std::logic_error("the coordinator left tasks undone");
    return speed_;
  }

 private:
  void feed(const Event& event) {
    std::vector<Command> commands;
    speed_.handling += timed([&] { commands = coordinator_.handle(event); });
    for (const Command& command : commands) {
      const auto* assign = std::get_if<Assign>(&command);
      if (assign == nullptr) continue;
      const Assignment& a = assign->assignment;
      speed_.messages += timed([&] { (void)encode_order(a); });
      TaskDone done{assign->worker, a.task.id, a.key, hash_text(a.key.hex()), false, {}, {}};
      done.figures = {{"rank", 50}, {"error", 0.0123}, {"energy", 0.987}, {"samples", 1000}};
      running_.push_back(std::move(done));
    }
  }

  Coordinator coordinator_;
  TasksAdded added_;
  std::vector<TaskDone> running_;
  CoordinatorSpeed speed_;
};

}  // namespace

CoordinatorSpeed measure_coordinator(std::size_t layers, std::size_t width, std::size_t inputs,
                                     int workers) {
  std::mt19937 random(1);
  return Race(layered_graph(layers, width, inputs, random)).run(workers, random);
}

}  // namespace prt::scaling
