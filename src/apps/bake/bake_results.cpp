#include "apps/bake/bake_results.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/bake/report.h"
#include "base/error.h"
#include "base/log.h"
#include "methods/common/sampling.h"
#include "store/index.h"

namespace prt {

namespace {

constexpr const char* kReportName = "report.json";
constexpr const char* kPageName = "report.html";
constexpr const char* kBudgetName = "budget.json";

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// What the finished tasks, found ones included, say about themselves.
History with_figures(const History& history, const ReadResult& result) {
  History full = history;
  full.fill_figures([&](const std::string& task) {
    const auto artifact = result(task);
    return artifact ? figures_of(*artifact) : nlohmann::json::object();
  });
  return full;
}

/// {direct, indirect}: relative error at samples under each test light; null where it is not there.
nlohmann::json errors_of_lights(const Artifact& evaluated) {
  constexpr const char* kArray = "rel_rmse_of_light";
  if (!evaluated.has(kArray)) return nullptr;
  const auto values = evaluated.values<float>(kArray);
  nlohmann::json direct = nlohmann::json::array(), indirect = nlohmann::json::array();
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    direct.push_back(values[i]);
    indirect.push_back(values[i + 1]);
  }
  return {{"direct", direct}, {"indirect", indirect}};
}

class Results {
 public:
  Results(const BakeFacts& facts, const BakePlan& plan, const ReadResult& result,
          const History& history, BakeFolder& folder, FileSystem& fs)
      : facts_(facts), plan_(plan), result_(result), history_(history), folder_(folder), fs_(fs) {}

  void write() {
    const double began = facts_.program.clock();
    encode();
    if (!plan_.time_limit.is_null()) {
      // Once, so that report and log tell the same; writing them is all that follows.
      time_limit_ = plan_.time_limit;
      add_used_seconds(time_limit_, seconds() + history_.earlier_seconds());
    }
    const bool is_new = !same_package() || history_.made() > 0 || !fs_.size(file(kCompleteName)) ||
                        !fs_.size(file(kReportName)) || !fs_.size(file(kIndexName)) ||
                        !reported_limit();
    if (is_new) {
      // Gone for good before anything changes that it vouches for.
      if (fs_.remove(file(kCompleteName))) fs_.sync_dir(folder_.path());
      replace_file(fs_, file(package_name()), package_);
      package_seconds_ = facts_.program.clock() - began;
      write_folder_index();
      write_report();
      replace_file(fs_, file(kCompleteName), bytes_of(marker()));
    }
    tell(is_new);
  }

 private:
  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return folder_.path() / name;
  }
  [[nodiscard]] std::string package_name() const {
    return folder_.path().filename().string() + ".prt.glb";
  }
  /// Of this run.
  [[nodiscard]] double seconds() const { return facts_.program.clock() - facts_.began; }

  void encode() {
    const auto of_level = [&](const std::string& task) { return result_(plan_.prefix + task); };
    Package package = facts_.config.method->assemble(of_level, plan_.options);
    package.scene = facts_.scene;
    if (facts_.program.evaluator && !plan_.evaluation_results.empty()) {
      for (const std::string& task : plan_.evaluation_results) {
        const auto evaluated = result_(task);
        if (!evaluated) continue;
        package.error.update(facts_.program.evaluator->error(*evaluated, facts_.scene.origin));
        if (error_of_light_.is_null()) error_of_light_ = errors_of_lights(*evaluated);
      }
    }
    if (!plan_.all.plays_lights && !plan_.all.plays_environment) {
      throw UserError(nothing_to_play());
    }
    error_ = package.error;
    package_ = facts_.program.encode_package(package);
    assembled_ = std::move(package);
    content_ = hash_bytes(package_);
  }

  [[nodiscard]] std::string nothing_to_play() const {
    std::string why = "scene: nothing of it can be relit";
    for (const LeftOut& what : plan_.all.left_out) why += "; no " + what.what + ": " + what.reason;
    return why + "; add lb to methods";
  }

  bool same_package() {
    if (fs_.size(file(package_name())) != package_.size()) return false;
    return hash_bytes(fs_.read(file(package_name()))) == content_;
  }

  /// Whether the report that is there tells of this time limit: another may well choose a level
  /// that is there already.
  [[nodiscard]] bool reported_limit() const {
    const nlohmann::json report = read_json(kReportName);
    const auto seconds_of = [](const nlohmann::json& limit) {
      return limit.is_object() ? limit.value("seconds", nlohmann::json()) : nlohmann::json();
    };
    return report.is_object() &&
           seconds_of(report.value("time_limit", nlohmann::json())) == seconds_of(plan_.time_limit);
  }

  /// A file of the bake's; what is no JSON is "discarded", which is neither object nor array.
  [[nodiscard]] nlohmann::json read_json(const std::string& name) const {
    const auto bytes = fs_.read(file(name));
    const auto* begin = reinterpret_cast<const char*>(bytes.data());
    return nlohmann::json::parse(begin, begin + bytes.size(), nullptr, false);
  }

  void write_folder_index() {
    std::vector<IndexEntry> entries;
    for (const TaskHistory& task : history_.tasks()) {
      if (!task.task.starts_with(plan_.prefix)) continue;              // of a coarser level
      if (folder_.store().bytes(task.stage, task.key) == 0) continue;  // let go
      entries.push_back({task.task.substr(plan_.prefix.size()), task.stage, task.key});
    }
    nlohmann::json attributes = nlohmann::json::object();
    if (facts_.scene.recentred()) attributes["origin"] = origin_of(facts_.scene);
    write_index(fs_, folder_.path(), entries, attributes);
  }

  void write_report() {
    double cpu_seconds = 0.0;
    for (const TaskHistory& task : history_.tasks()) {
      if (task.made) cpu_seconds += task.cost.cpu_seconds;
    }
    const nlohmann::json error = error_.empty() ? nlohmann::json(nullptr) : error_;
    const History history = with_figures(history_, result_);
    const ReportFacts facts{facts_.config,  facts_.scene,      plan_,          error,
                            package_name(), package_.size(),   content_,       seconds(),
                            cpu_seconds,    facts_.ranks,      facts_.hosts,   facts_.threads,
                            facts_.isa,     facts_.prediction, survey(history)};
    nlohmann::json report = make_report(facts, history);
    report["time_limit"] = time_limit_;
    report["error_of_light"] = error_of_light_;
    constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
    report["this_run"]["package_seconds"] = package_seconds_;
    replace_file(fs_, file(kReportName), bytes_of(report.dump(2, ' ', false, kReplace) + "\n"));
    replace_file(fs_, file(kPageName), bytes_of(report_page(report, pictures(history), budget())));
  }

  /// The page is worth having without them.
  [[nodiscard]] std::vector<ReportPicture> pictures(const History& history) const {
    if (!facts_.program.draw_pictures) return {};
    std::vector<TaskHistory> tasks;  // of the level that became the package
    for (TaskHistory task : history.tasks()) {
      if (!task.task.starts_with(plan_.prefix)) continue;
      task.task.erase(0, plan_.prefix.size());
      tasks.push_back(std::move(task));
    }
    const auto result = [&](const std::string& task) { return result_(plan_.prefix + task); };
    try {
      return facts_.program.draw_pictures(assembled_, result, tasks);
    } catch (const std::exception& e) {
      log::warn("{} has no pictures: {}", kPageName, e.what());
      return {};
    }
  }

  /// What finer settings would bring, if somebody measured it; null if not.
  [[nodiscard]] nlohmann::json budget() const {
    if (!fs_.size(file(kBudgetName))) return nullptr;
    nlohmann::json budget = read_json(kBudgetName);
    const bool sound = budget.is_object() && budget.contains("rows") && budget["rows"].is_array();
    if (sound) return budget;
    log::warn("{}: no error budget can be read from it; {} goes without",
              file(kBudgetName).string(), kPageName);
    return nullptr;
  }

  [[nodiscard]] nlohmann::json survey(const History& history) const {
    const auto samples = result_(plan_.prefix + kSamplesTask);
    const auto albedo = result_(plan_.prefix + kAlbedoTask);
    if (!samples || !albedo) return nullptr;
    std::vector<nlohmann::json> rays;
    for (const TaskHistory& task : history.tasks()) {
      const bool of_level = task.task.starts_with(plan_.prefix);
      if (of_level && task.stage == "rays") rays.push_back(task.figures);
    }
    return survey_scene(facts_.scene, rays, *samples, *albedo);
  }

  [[nodiscard]] std::string marker() const {
    return nlohmann::json{{"package", package_name()},
                          {"package_content", content_.hex()},
                          {"tasks", history_.tasks().size()}}
               .dump() +
           "\n";
  }

  /// A goal that was missed is no failure, and nothing to keep quiet about either.
  void tell_accuracy() const {
    if (plan_.accuracy.is_null()) return;
    const nlohmann::json& last = plan_.accuracy["levels"].back();
    const std::string reached =
        fmt::format("indirect {}, visibility {} at level {}", last["indirect"].dump(),
                    last["visibility"].dump(), last["level"].dump());
    const bool is_finest = last["level"] == facts_.config.method->effort_levels() - 1;
    if (plan_.accuracy["met"].get<bool>()) {
      log::info("accuracy: goal {} met: {}", plan_.accuracy["goal"].dump(), reached);
    } else {
      log::warn("accuracy: goal {} NOT met {}: {}", plan_.accuracy["goal"].dump(),
                is_finest ? "by the finest level" : "within the time limit", reached);
    }
  }

  /// A limit too short for the coarsest level is no failure either.
  void tell_time_limit() const {
    if (time_limit_.is_null()) return;
    const auto seconds = time_limit_["seconds"].get<double>();
    const auto used = time_limit_["used_seconds"].get<double>();
    const auto level = time_limit_["level"].get<int>();
    if (time_limit_["met"].get<bool>()) {
      log::info("time limit {:.1f} s: level {} in {:.1f} s", seconds, level, used);
    } else if (level == 0) {
      log::warn("time limit {:.1f} s is too short for the coarsest level: {:.1f} s, {:.1f} s over",
                seconds, used, used - seconds);
    } else {
      log::warn("time limit {:.1f} s NOT met: level {} in {:.1f} s, {:.1f} s over", seconds, level,
                used, used - seconds);
    }
  }

  void tell(bool is_new) const {
    tell_accuracy();
    tell_time_limit();
    const std::size_t all = history_.tasks().size();
    if (!is_new) {
      log::info("already done: all {} artifacts are sound and {} is unchanged ({:.1f} s)", all,
                file(package_name()).string(), seconds());
      return;
    }
    constexpr double kMega = 1e6;
    log::info("done: {} ({:.1f} MB); {} tasks made, {} found, {:.1f} s",
              file(package_name()).string(), static_cast<double>(package_.size()) / kMega,
              history_.made(), all - history_.made(), seconds());
  }

  const BakeFacts& facts_;
  const BakePlan& plan_;
  const ReadResult& result_;
  const History& history_;
  BakeFolder& folder_;
  FileSystem& fs_;
  double package_seconds_ = 0.0;  // assembled from artifacts, encoded and written
  std::vector<std::byte> package_;
  Digest content_;
  Package assembled_;
  nlohmann::json error_ = nlohmann::json::object();
  nlohmann::json error_of_light_;  // null: not measured
  nlohmann::json time_limit_;      // BakePlan::time_limit, and what became of it
};

}  // namespace

void write_results(const BakeFacts& facts, const BakePlan& plan, const ReadResult& result,
                   const History& history, BakeFolder& folder, FileSystem& fs) {
  Results(facts, plan, result, history, folder, fs).write();
}

void write_trace(FileSystem& fs, const std::filesystem::path& file, const History& history) {
  replace_file(fs, file, bytes_of(chrome_trace(history.tasks())));
}

}  // namespace prt
