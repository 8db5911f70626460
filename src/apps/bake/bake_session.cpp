#include "apps/bake/bake_session.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <optional>
#include <thread>

#include "apps/bake/agreement.h"
#include "apps/bake/bake_host.h"
#include "apps/bake/bake_results.h"
#include "apps/bake/bake_runner.h"
#include "apps/bake/cpu_share.h"
#include "apps/bake/preview.h"
#include "apps/bake/signals.h"
#include "base/log.h"
#include "store/bake_folder.h"

namespace prt {

namespace {

/// How long a rank may take to go home: after a signal Open MPI kills what is left after a second;
/// after a failure others may be in the middle of something.
constexpr std::chrono::milliseconds kInterruptedWithin{700};
constexpr std::chrono::milliseconds kFailedWithin{5000};

/// One late message is no silence.
constexpr double kHeartbeatsPerLease = 6.0;
/// The coordinator is silent while it plans and writes results.
constexpr double kLeasesOfPatience = 20.0;

void leave_soon(ExitCode code) {
  if (code == ExitCode::kInterrupted) end_within(kInterruptedWithin, code);
  if (code == ExitCode::kFailure || code == ExitCode::kBadInput) end_within(kFailedWithin, code);
}

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

std::string fingerprint(const BakeConfig& config) {
  nlohmann::json all = nlohmann::json::object();
  for (const auto& [key, value] : config.options.all()) all[key] = value;
  const Digest digest = Hasher()
                            .add(config.method->name())
                            .add(config.scene.filename().string())
                            .add(all.dump())
                            .digest();
  return digest.hex();
}

/// Whose bake a folder is: another scene's is refused, while other methods, options, albedos or
/// lights go on with what they share.
std::string identity(const Scene& scene, const std::string& isa) {
  return "geometry " + scene.geometry_hash.hex() + ", instruction set " + isa;
}

/// The instruction set a folder was begun with, if it says so.
std::optional<std::string> begun_with(FileSystem& fs, const std::filesystem::path& dir) {
  static const std::string kBefore = "instruction set ";
  const ManifestContents found = read_manifest(fs, dir / kManifestName);
  const std::size_t at = found.identity.rfind(kBefore);
  if (at == std::string::npos) return std::nullopt;
  return found.identity.substr(at + kBefore.size());
}

class Session {
 public:
  Session(const BakeCommand& command, const BakeProgram& program, Ranks& ranks)
      : command_(command),
        program_(program),
        ranks_(ranks),
        began_(program.clock()),
        fs_(*program.file_system) {}

  ExitCode run() {
    do_together(ranks_, [&] {
      config_ = load_config(command_.config, command_.overrides, program_.methods);
    });
    expect_same(ranks_, fingerprint(config_), "different configurations");
    do_together(ranks_, [&] { scene_ = program_.load_scene(config_.scene); });
    hashes_ = {scene_.geometry_hash, scene_.materials_hash, scene_.lights_hash};
    expect_same(ranks_, hashes_.geometry.hex() + hashes_.materials.hex() + hashes_.lights.hex(),
                "different scenes under one name");
    if (ranks_.rank() == 0) {
      for (const std::string& note : scene_.repairs.notes) log::info("scene: {}", note);
    }
    if (command_.plan_only) return show_plan();
    settle_isa();
    do_together(ranks_, [&] {
      if (ranks_.rank() != 0) return;
      folder_ = BakeFolder::open(fs_, config_.output, identity(scene_, isa_), command_.fresh);
    });
    // Last, so that what is wrong with the input is told alone. No thread runs yet.
    share_machine();
    return ranks_.rank() == 0 ? coordinate() : work();
  }

 private:
  void share_machine() {
    const CpuShare share = share_cpus(ranks_.node_size());
    threads_ = command_.threads > 0 ? command_.threads : share.threads;
    if (ranks_.node_rank() == 0) {
      log::info("{} {} on {} share {} CPUs: {} {} each{}", ranks_.node_size(),
                ranks_.node_size() == 1 ? "rank" : "ranks", host_name(), share.cpus, threads_,
                threads_ == 1 ? "thread" : "threads",
                share.widened ? "; the launcher's default binding was widened" : "");
    }
    total_threads_ = 0;
    for (const std::string& t : ranks_.gather_all(std::to_string(threads_))) {
      total_threads_ += std::stoi(t);
    }
    hosts_ = ranks_.gather_all(host_name());
  }

  ExitCode show_plan() {
    do_together(ranks_, [&] {
      if (ranks_.rank() != 0) return;
      const ArtifactStore store(fs_, config_.output);
      Planner planner(program_, *config_.method, config_.options, scene_, store);
      const ManifestContents manifest = read_manifest(fs_, config_.output / kManifestName);
      std::fputs(preview_plan(planner, store, hashes_, manifest).c_str(), stdout);
      if (by_levels()) {
        std::fputs(
            "\nWhat is asked for is aimed at level by level; this is the coarsest, and each "
            "further one takes 2 to 3 times as long.\n",
            stdout);
      }
      const auto prediction = predict_bake(
          program_, *config_.method,
          by_levels() ? options_at(*config_.method, config_.options, 0) : config_.options, scene_,
          program_.best_isa(), stop_flag());
      if (!prediction) return;
      const int threads =
          command_.threads > 0 ? command_.threads : share_cpus(ranks_.node_size()).threads;
      std::fputs(prediction_text(*prediction, threads, ranks_.size()).c_str(), stdout);
      if (!by_levels()) return;
      std::vector<double> seconds;
      seconds.reserve(static_cast<std::size_t>(config_.method->effort_levels()));
      for (int level = 0; level < config_.method->effort_levels(); ++level) {
        seconds.push_back(expected_seconds(program_, *config_.method, prediction->made,
                                           options_at(*config_.method, config_.options, level),
                                           threads * ranks_.size()));
      }
      std::fputs(levels_text(seconds).c_str(), stdout);
    });
    return ExitCode::kDone;
  }

  /// All ranks use one instruction set, and a bake goes on with the one it was begun with: results
  /// may differ in their last bit between two.
  void settle_isa() {
    const std::string common = lowest_isa(ranks_.gather_all(program_.best_isa()));
    do_together(ranks_, [&] {
      isa_ = common;
      if (ranks_.rank() != 0 || command_.fresh) return;
      isa_ = begun_with(fs_, config_.output).value_or(common);
      if (!can_run(common, isa_)) {
        throw UserError(config_.output.string() + ": this bake was begun with instruction set " +
                        isa_ +
                        ", which this machine lacks; go on where it began, or use --fresh or "
                        "another --out");
      }
    });
    isa_ = ranks_.broadcast(isa_);
  }

  [[nodiscard]] BakeWorld world(ArtifactStore& store) const {
    return {program_, *config_.method, config_.options, scene_, isa_, store};
  }

  [[nodiscard]] ServiceSettings service_settings() const {
    ServiceSettings settings;
    settings.stop = &stop_flag();
    settings.drain = &drain_flag();
    settings.grace_seconds = config_.options.get<double>("jobs.grace");
    settings.heartbeat_seconds = lease() / kHeartbeatsPerLease;
    settings.patience_seconds = lease() * kLeasesOfPatience;
    return settings;
  }

  ExitCode work() {
    ArtifactStore store(fs_, config_.output);
    BakeRunner runner(world(store));
    Slots slots(threads_, runner);
    try {
      const ExitCode code = run_worker(ranks_.link(), slots, service_settings());
      leave_soon(code);
      return code;
    } catch (const std::exception& e) {
      throw RankFailure(e.what());
    }
  }

  [[nodiscard]] Coordinator::Settings coordinator_settings() const {
    Coordinator::Settings settings;
    settings.scene = hashes_;
    settings.lease_seconds = lease();
    if (keep_all()) return settings;
    for (const ManifestEntry& entry : folder_->found().entries) {
      if (folder_->store().bytes(entry.kind, entry.key) == 0) settings.spared.insert(entry.key);
    }
    return settings;
  }

  [[nodiscard]] double lease() const { return config_.options.get<double>("jobs.lease"); }

  [[nodiscard]] bool keep_all() const {
    return config_.options.get<std::string>("store.keep") == "all";
  }

  [[nodiscard]] bool by_levels() const {
    return AccuracyGoal(config_.options).wanted() || time_limit_of(config_.options);
  }

  /// While a large bake begins: what the report compares with what then happens. It costs about a
  /// second of CPU, so small bakes go without.
  [[nodiscard]] std::unique_ptr<PredictionBeside> predict() const {
    constexpr double kWorthwhileRays = 2e7;
    const OptionValues& o = config_.options;
    if (!folder_->found().entries.empty() || !o.is_set("samples.count")) return nullptr;
    if (by_levels()) return nullptr;  // nobody knows how many levels it takes
    const double rays = o.get<double>("samples.count") * o.get<double>("rays.directions");
    if (rays < kWorthwhileRays) return nullptr;
    return std::make_unique<PredictionBeside>([this](const std::atomic<bool>& stop) {
      return predict_bake(program_, *config_.method, config_.options, scene_, isa_, stop);
    });
  }

  ExitCode coordinate() {
    const auto prediction = predict();
    KnownContents known;
    for (const ManifestEntry& entry : folder_->found().entries) known[entry.key] = entry.content;
    Coordinator coordinator(coordinator_settings(), std::move(known));
    History history(folder_->found().made);
    std::optional<TimedLevels> timed;
    if (const auto limit = time_limit_of(config_.options)) {
      timed.emplace(program_, *config_.method, config_.options, scene_,
                    TimedLevels::Budget{*limit, began_, total_threads_}, history, *folder_);
    }
    Planner planner(program_, *config_.method, config_.options, scene_, folder_->store(),
                    timed ? &*timed : nullptr);
    BakeRunner runner(world(folder_->store()));
    Slots slots(threads_, runner);
    const auto write = [&](const Host& host, const FindResult& find) {
      finish(planner, host, find, prediction ? prediction->get() : nullptr);
    };
    Host host(planner, history, fs_, *folder_, write, keep_all(), command_.verbosity);
    LoopEnd end = guarded([&] {
      return run_coordinator(coordinator, host, ranks_.link(), slots, service_settings());
    });
    const LoopEnd closing = guarded([&] {
      folder_->manifest().sync();
      if (!command_.trace.empty()) write_trace(fs_, command_.trace, host.history());
      return LoopEnd{};
    });
    if (end.code == ExitCode::kDone) end = closing;
    dismiss_all(ranks_.link(), end.code);
    say(end, host);
    leave_soon(end.code);
    // The orderly end waits for every rank, and one that is lost never comes to it.
    if (const auto lost = coordinator.lost(); !lost.empty()) {
      ranks_.abort_without(lost, static_cast<int>(end.code));
    }
    return end.code;
  }

  static LoopEnd guarded(const std::function<LoopEnd()>& step) {
    try {
      return step();
    } catch (const UserError& e) {
      return {ExitCode::kBadInput, e.what()};
    } catch (const std::exception& e) {
      return {ExitCode::kFailure, e.what()};
    }
  }

  void finish(Planner& planner, const Host& host, const FindResult& find,
              const BakePrediction* prediction) {
    const auto result = [&](const std::string& task) { return planner.read(task, find); };
    const BakeFacts facts{program_,       config_,       scene_, isa_,      hosts_,
                          total_threads_, ranks_.size(), began_, prediction};
    write_results(facts, host.plan(), result, host.history(), *folder_, fs_);
  }

  void say(const LoopEnd& end, const Host& host) const {
    if (!end.message.empty()) std::fprintf(stderr, "prt_bake: %s\n", end.message.c_str());
    if (end.code == ExitCode::kInterrupted) {
      log::warn("interrupted after {} tasks; the same command goes on from here",
                host.history().tasks().size());
    }
  }

  const BakeCommand& command_;
  const BakeProgram& program_;
  Ranks& ranks_;
  double began_;
  FileSystem& fs_;
  BakeConfig config_;
  Scene scene_;
  SceneHashes hashes_;
  std::string isa_;
  int threads_ = 1;
  int total_threads_ = 1;
  std::vector<std::string> hosts_;
  mutable std::optional<BakeFolder> folder_;
};

}  // namespace

ExitCode bake(const BakeCommand& command, const BakeProgram& program, Ranks& ranks) {
  return Session(command, program, ranks).run();
}

}  // namespace prt
