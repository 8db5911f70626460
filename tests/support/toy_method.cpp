#include "support/toy_method.h"

#include <chrono>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <thread>

#include "base/error.h"
#include "base/random.h"

namespace prt {
namespace {

std::string environment(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? text : "";
}

void spin(const TaskReader& reader) {
  const std::string text = environment("PRT_TOY_SPIN_US");
  if (text.empty()) return;
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(std::stol(text));
  while (std::chrono::steady_clock::now() < end) {
    if (reader.stop_requested()) throw Interrupted("asked to stop");
  }
}

void fail_if_told(const std::string& id) {
  if (id != environment("PRT_TOY_FAIL")) return;
  const std::string kind = environment("PRT_TOY_FAIL_KIND");
  if (kind == "user") throw UserError("toy.scene: the toy is broken; mend it");
  if (kind == "memory") throw std::bad_alloc();
  throw std::runtime_error("a bug in the toy");
}

class ToyMethod : public Method {
 public:
  [[nodiscard]] std::string name() const override { return "toy"; }

  [[nodiscard]] std::vector<OptionSpec> options() const override {
    constexpr int kMostLeaves = 10000;
    return {{"toy.leaves",
             OptionSpec::Type::kInteger,
             40,
             2,
             kMostLeaves,
             {},
             "leaves",
             "tasks of the first stage",
             "ours"},
            {"toy.values",
             OptionSpec::Type::kInteger,
             1000,
             1,
             1'000'000,
             {},
             "values",
             "numbers in an artifact",
             "ours"}};
  }

  [[nodiscard]] Plan plan(const PlanInputs& inputs) const override {
    Plan plan;
    plan.plays_lights = true;
    const int leaves = inputs.options().get<int>("toy.leaves");
    for (int i = 0; i < leaves; ++i) {
      TaskSpec task = make("leaf", i);
      task.parameters = {{"index", i},
                         {"seed", inputs.options().get<std::uint64_t>("seed")},
                         {"values", inputs.options().get<int>("toy.values")}};
      task.scene_parts = kGeometry;
      task.cost = 1.0 + i % 3;
      plan.tasks.push_back(std::move(task));
    }
    for (int i = 0; i + 1 < leaves; i += 2) {
      TaskSpec task = make("pair", i / 2);
      task.inputs = {id("leaf", i), id("leaf", i + 1)};
      plan.tasks.push_back(std::move(task));
    }
    if (!inputs.result(id("leaf", 0))) return plan;
    TaskSpec total = make("total", 0);
    for (int i = 0; i + 1 < leaves; i += 2) total.inputs.push_back(id("pair", i / 2));
    plan.tasks.push_back(std::move(total));
    plan.results = {id("total", 0)};
    plan.left_out = {{"the odd leaf", "it has no partner"}};
    plan.complete = true;
    return plan;
  }

  [[nodiscard]] std::string equation(const std::string&) const override { return {}; }
  [[nodiscard]] std::vector<std::string> kinds() const override {
    return {"leaf", "pair", "total"};
  }

  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader) const override {
    fail_if_told(task.id);
    spin(reader);
    Artifact artifact;
    std::vector<float> sum;
    if (task.kind == "leaf") {
      Random random(stream_key(task.parameters.at("seed"), "leaf"), task.parameters.at("index"));
      sum.resize(task.parameters.at("values"));
      for (float& v : sum) v = random.uniform();
    } else {
      for (std::size_t i = 0; i < task.inputs.size(); ++i) {
        const auto values = reader.input(i)->vector<float>("values");
        sum.resize(values.size(), 0.0F);
        for (std::size_t k = 0; k < values.size(); ++k) sum[k] += values[k];
      }
    }
    artifact.put<float>("values", sum, {sum.size()}, "1", "numbers of the toy");
    artifact.attributes["error"] = sum[0];
    return artifact;
  }

  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>& result,
      const OptionValues&) const override {
    Package package;
    package.provenance["total"] = result(id("total", 0))->vector<float>("values");
    return package;
  }

 private:
  static std::string id(const std::string& kind, int index) {
    const std::string digits = std::to_string(index);
    return kind + "/" + std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits;
  }
  static TaskSpec make(const std::string& kind, int index) {
    TaskSpec task;
    task.id = id(kind, index);
    task.kind = kind;
    return task;
  }
};

class LevelledToy : public ToyMethod {
 public:
  explicit LevelledToy(std::function<void(const std::string&)> before_task)
      : before_task_(std::move(before_task)) {}

  [[nodiscard]] int effort_levels() const override { return 3; }
  [[nodiscard]] OptionValues with_effort(const OptionValues& options, int level) const override {
    OptionValues at = options;
    at.set("toy.leaves", 10 << level);
    at.set("toy.values", 100 << level);
    return at;
  }
  [[nodiscard]] std::vector<StageWork> work(const BakeSize&, const OptionValues& options,
                                            const StageFigures&) const override {
    const auto leaves = options.get<double>("toy.leaves");
    return {{"leaf", leaves, 0, leaves, leaves, 1},
            {"pair", leaves / 2, 0, leaves, leaves, 1},
            {"total", leaves, 0, leaves, 1, 1}};  // so that all of it doubles
  }
  [[nodiscard]] Artifact run(const TaskSpec& task, const TaskReader& reader) const override {
    before_task_(task.id);
    return ToyMethod::run(task, reader);
  }

 private:
  std::function<void(const std::string&)> before_task_;
};

/// The scene is the text of its file.
Scene load_toy_scene(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw UserError(file.string() + ": there is no such scene file");
  Scene scene;
  scene.geometry_hash = hash_text(file.filename().string());
  return scene;
}

/// A disk that takes its time over files that grow.
class SlowFileSystem : public PosixFileSystem {
 public:
  explicit SlowFileSystem(std::chrono::milliseconds delay) : delay_(delay) {}
  std::unique_ptr<WritableFile> open_append(const Path& path) override {
    return std::make_unique<SlowFile>(PosixFileSystem::open_append(path), delay_);
  }

 private:
  class SlowFile : public WritableFile {
   public:
    SlowFile(std::unique_ptr<WritableFile> file, std::chrono::milliseconds delay)
        : file_(std::move(file)), delay_(delay) {}
    void append(std::span<const std::byte> bytes) override { file_->append(bytes); }
    void sync() override {
      std::this_thread::sleep_for(delay_);
      file_->sync();
    }

   private:
    std::unique_ptr<WritableFile> file_;
    std::chrono::milliseconds delay_;
  };

  std::chrono::milliseconds delay_;
};

std::shared_ptr<FileSystem> toy_file_system() {
  const std::string delay = environment("PRT_TOY_SLOW_SYNC_MS");
  if (delay.empty()) return std::make_shared<PosixFileSystem>();
  return std::make_shared<SlowFileSystem>(std::chrono::milliseconds(std::stol(delay)));
}

std::vector<std::byte> encode_toy_package(const Package& package) {
  const std::string text = package.provenance.dump();
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

namespace test {

namespace {

BakeProgram program_of(const Method& toy) {
  return {{&toy},
          nullptr,
          load_toy_scene,
          [](const Scene&, const std::string&) { return std::unique_ptr<RayCaster>(); },
          [] { return std::string("avx2"); },
          encode_toy_package,
          toy_file_system()};
}

}  // namespace

BakeProgram toy_program() {
  static const ToyMethod toy;
  return program_of(toy);
}

BakeProgram toy_program_with_levels(std::function<void(const std::string& task)> before_task) {
  static std::vector<std::unique_ptr<LevelledToy>> toys;  // a program only points at its methods
  toys.push_back(std::make_unique<LevelledToy>(std::move(before_task)));
  return program_of(*toys.back());
}

}  // namespace test
}  // namespace prt
