// A kind of task whose results change must get a new code version (design: KEY), or old artifacts
// would be taken for new ones. Tiny bakes are compared with kind_bytes.json, which holds for each
// kind its version and hashes of what it read and made.
//
// Floating-point results are the same only for one compiler, build type and set of headers: there,
// all bytes are compared; elsewhere names, types, units and meanings alone.
//
// After raising a version: PRT_RECORD_BYTES=1 build/release/bin/kind_bytes_test
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "evaluate/bake_evaluation.h"
#include "evaluate/sky_evaluation.h"
#include "methods/common/sampling.h"
#include "methods/lb/lb.h"
#include "methods/sh/sh.h"
#include "scene/load.h"
#include "store/hdf5_image.h"
#include "store/seal.h"
#include "support/in_process_bake.h"
#include "support/tiled_sampling.h"

namespace prt {
namespace {

using nlohmann::json;

const std::string kRecord = std::string(PRT_SOURCE_DIR) + "/tests/unit/lb/kind_bytes.json";

std::string platform() {
  std::ostringstream text;
  text << "compiler " << __VERSION__ << ", " << PRT_BUILD_FLAVOUR << ", Eigen "
       << EIGEN_WORLD_VERSION << '.' << EIGEN_MAJOR_VERSION << '.' << EIGEN_MINOR_VERSION;
  return text.str();
}

/// What does not depend on rounding: names, types, ranks of arrays, units, meanings.
void add_structure(Hasher& hasher, const Artifact& artifact) {
  for (const auto& [name, dataset] : artifact.datasets) {
    hasher.add(name).add(std::to_string(static_cast<int>(dataset.type)));
    hasher.add(std::to_string(dataset.dims.size())).add(dataset.units).add(dataset.meaning);
  }
  for (const auto& [name, value] : artifact.attributes.items()) {
    hasher.add(name).add(value.is_number_integer() ? "integer" : value.type_name());
  }
}

Digest content_of(const TaskSpec& task, const Artifact& artifact, const Method& method) {
  const ArtifactLabel label{task.kind, hash_text(task.id), task.version,
                            method.equation(task.kind)};
  return verify_seal(to_hdf5(artifact, label));
}

struct KindHashes {
  int version = 0;
  Hasher structure, inputs, outputs;
};

/// Runs a tiny bake and hashes it by kind.
class TinyBake : public test::InProcessBake {
 public:
  TinyBake(const Scene& scene, const OptionValues& options, const Method& method)
      : InProcessBake(scene, options, "avx2"), options_(options), method_(method) {}

  /// A whole one, its evaluation included.
  void run_all() {
    Plan plan = run(method_);
    Plan evaluation = plan.plays_lights
                          ? plan_evaluation(options_, kSamplesTask, &plan.results)
                          : plan_sky_evaluation(options_, kSamplesTask, &plan.results);
    for (const TaskSpec& task : evaluation.tasks) evaluate(task);
    std::ranges::move(evaluation.tasks, std::back_inserter(plan.tasks));
    for (const TaskSpec& task : plan.tasks) add(task);
  }
  /// Sampling alone, in tiles as of a large scene.
  void run_in_tiles() {
    const test::TiledSampling method(ThinningSplit{60000, 1, 2});
    for (const TaskSpec& task : run(method).tasks) add(task);
  }

  [[nodiscard]] json hashes() {
    json all;
    for (auto& [kind, h] : kinds_) {
      all[kind] = {{"version", h.version},
                   {"structure", h.structure.digest().hex()},
                   {"inputs", h.inputs.digest().hex()},
                   {"outputs", h.outputs.digest().hex()}};
    }
    return all;
  }

 private:
  void evaluate(const TaskSpec& task) {
    const auto find = [this](const std::string& id) { return result(id); };
    run_task(task, [&](const TaskReader& reader) {
      if (task.kind == "reference") return run_reference(task, reader);
      if (task.kind == "evaluate") return run_evaluate(task, reader);
      if (task.kind == "sky_reference") return run_sky_reference(task, reader);
      const Package package = method_.assemble(find, options_);
      const Evaluator player(package, {.threads = 1});
      return task.kind == "sky_evaluate" ? run_sky_evaluate(task, reader, player)
                                         : run_compare(task, reader, player);
    });
  }

  void add(const TaskSpec& task) {
    const Artifact& artifact = *result(task.id);
    KindHashes& kind = kinds_[task.kind];
    kind.version = task.version;
    kind.inputs.add(task.parameters.dump());
    for (const std::string& id : task.inputs) kind.inputs.add(contents_.at(id));
    contents_[task.id] = content_of(task, artifact, method_).hex();
    kind.outputs.add(contents_.at(task.id));
    add_structure(kind.structure, artifact);
  }

  OptionValues options_;
  const Method& method_;
  std::map<std::string, std::string> contents_;
  std::map<std::string, KindHashes> kinds_;
};

/// `way`: a solver, "regions" for gathering in regions, "tiles" for sampling in tiles, or "sky" for
/// the transfer of environments.
json bake_by_kind(const std::string& way) {
  const Scene scene = load_scene(std::string(PRT_SOURCE_DIR) + "/configs/scenes/cornell.glb");
  const Method& method = way == "sky" ? sh_method() : lb_method();
  OptionValues options = test::default_options(method);
  std::map<std::string, json> tiny = {{"samples.count", 300},  {"samples.cluster_size", 75},
                                      {"rays.directions", 64}, {"evaluate.lights", 2},
                                      {"evaluate.points", 20}, {"evaluate.spp", 4}};
  if (way != "sky") {
    tiny.insert({{"lb.example_lights", 40},
                 {"lb.light_rank", 3},
                 {"lb.solver", way == "photons" ? way : "gather"},
                 {"lb.photons", 20000}});
  }
  for (const auto& [key, value] : tiny) options.set(key, value);
  if (way == "regions") {
    options.set("lb.region_clusters", 2);
    options.set("lb.window_tolerance", 0.2);
  }
  if (way == "tiles") options.set("samples.count", 9000);
  TinyBake bake(scene, options, method);
  if (way == "tiles") {
    bake.run_in_tiles();
  } else {
    bake.run_all();
  }
  return bake.hashes();
}

void compare(const std::string& kind, const json& known, const json& now, bool same_platform) {
  const int version = now.at("version");
  const std::string raise = "the results of kind '" + kind + "' changed: raise its code version (" +
                            std::to_string(version) + ") where it is planned, then record anew";
  const int recorded = known.at("version");
  EXPECT_GE(version, recorded) << kind << ": a version never goes back";
  if (version != recorded) {
    ADD_FAILURE() << kind << ": record version " << version << " with PRT_RECORD_BYTES=1";
    return;
  }
  EXPECT_EQ(known.at("structure"), now.at("structure")) << raise;
  if (!same_platform) return;
  if (known.at("inputs") != now.at("inputs")) {
    ADD_FAILURE() << kind << ": reads other inputs or parameters than recorded; record anew";
    return;
  }
  EXPECT_EQ(known.at("outputs"), now.at("outputs")) << raise;
}

json read_record() {
  std::ifstream in(kRecord);
  return in ? json::parse(in) : json::object();
}

class KindBytes : public testing::TestWithParam<const char*> {};

TEST_P(KindBytes, AKindWhoseResultsChangeGetsANewVersion) {
  const std::string way = GetParam();
  const json now = bake_by_kind(way);
  json record = read_record();
  if (std::getenv("PRT_RECORD_BYTES") != nullptr) {
    record["platform"] = platform();
    record[way] = now;
    std::ofstream(kRecord) << record.dump(2) << "\n";
    GTEST_SKIP() << "recorded in " << kRecord;
  }
  const bool same_platform = record.at("platform") == platform();
  if (!same_platform) {
    std::printf("recorded with %s, this is %s: only names and types are compared\n",
                record.at("platform").get<std::string>().c_str(), platform().c_str());
  }
  for (const auto& [kind, hashes] : now.items()) {
    ASSERT_TRUE(record.at(way).contains(kind)) << kind << " is new: record it";
    compare(kind, record.at(way).at(kind), hashes, same_platform);
  }
  EXPECT_EQ(record.at(way).size(), now.size()) << "kinds that are gone are still recorded";
}
INSTANTIATE_TEST_SUITE_P(Ways, KindBytes,
                         testing::Values("gather", "photons", "regions", "tiles", "sky"));

}  // namespace
}  // namespace prt
