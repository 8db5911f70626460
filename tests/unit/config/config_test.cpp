#include "apps/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace prt {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using Type = OptionSpec::Type;

class FakeMethod : public Method {
 public:
  [[nodiscard]] std::string name() const override { return "lb"; }
  [[nodiscard]] std::vector<OptionSpec> options() const override {
    return {
        {"lb.visibility_rank", Type::kInteger, 50, 1, 1000, {}, "", "rank", "eq. 9"},
        {"lb.distance_bias", Type::kNumber, 0.07, 0.0, 1.0, {}, "1", "bias", "ours"},
        {"lb.solver", Type::kText, "gather", 0, 0, {"gather", "photons"}, "", "solver", "ours"}};
  }
  [[nodiscard]] Plan plan(const PlanInputs&) const override { return {}; }
  [[nodiscard]] std::vector<std::string> kinds() const override { return {}; }
  [[nodiscard]] std::string equation(const std::string&) const override { return {}; }
  [[nodiscard]] Artifact run(const TaskSpec&, const TaskReader&) const override { return {}; }
  [[nodiscard]] Package assemble(
      const std::function<std::shared_ptr<const Artifact>(const std::string&)>&,
      const OptionValues&) const override {
    return {};
  }
};

class ConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "prt-config-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& text) {
    const fs::path file = folder_ / "a.yaml";
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  BakeConfig load(const std::string& text, const ConfigOverrides& overrides = {}) {
    return load_config(write(text), overrides, {&method_});
  }
  /// The message of the UserError; it must be one line.
  std::string error(const std::string& text, const ConfigOverrides& overrides = {}) {
    return error_of(write(text), overrides);
  }
  std::string error_of(const fs::path& file, const ConfigOverrides& overrides = {}) {
    try {
      load_config(file, overrides, {&method_});
    } catch (const UserError& e) {
      const std::string message = e.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message;
    }
    return "no error";
  }

  FakeMethod method_;
  fs::path folder_;
};

TEST_F(ConfigTest, DefaultsComeFromTheTables) {
  const BakeConfig config = load("scene: a.glb\n");
  EXPECT_EQ(config.method.get(), &method_);
  EXPECT_EQ(config.options.get<int>("samples.count"), 45000);
  EXPECT_EQ(config.options.get<int>("lb.visibility_rank"), 50);
  EXPECT_TRUE(config.options.is_auto("samples.start"));
  EXPECT_FALSE(config.options.is_set("samples.spacing"));
}

TEST_F(ConfigTest, ReadsValuesOfEveryType) {
  const BakeConfig config = load(
      "scene: a.glb\nseed: 7\nmethods: [lb]\nsamples: {count: 100, start: [1, 2.5, -3]}\n"
      "lb:\n  distance_bias: 1\n  solver: photons\ntransport: {tolerance: 1.0e-4, bounces: 3}\n"
      "compression:\n  bits: 16\n");
  EXPECT_EQ(config.options.get<int>("seed"), 7);
  EXPECT_EQ(config.options.get<std::vector<double>>("samples.start"),
            (std::vector<double>{1.0, 2.5, -3.0}));
  EXPECT_TRUE(config.options.at("lb.distance_bias").is_number_float());
  EXPECT_EQ(config.options.get<std::string>("lb.solver"), "photons");
  EXPECT_DOUBLE_EQ(config.options.get<double>("transport.tolerance"), 1e-4);
  EXPECT_EQ(config.options.get<int>("transport.bounces"), 3);
  EXPECT_EQ(config.options.get<int>("compression.bits"), 16);
}

TEST_F(ConfigTest, SeveralMethodsAreOneWithTheOptionsOfAll) {
  class Other : public FakeMethod {
   public:
    [[nodiscard]] std::string name() const override { return "sh"; }
    [[nodiscard]] std::vector<OptionSpec> options() const override {
      return {{"sh.order", Type::kInteger, 5, 1, 8, {}, "", "bands", "SH"}};
    }
  } other;
  const std::vector<const Method*> all = {&method_, &other};
  const auto load_both = [&](const std::string& methods, const std::string& setting = "seed=1") {
    return load_config(write("scene: a.glb\nmethods: " + methods + "\n"), {{setting}, {}}, all);
  };
  const BakeConfig both = load_both("[sh, lb]");
  EXPECT_EQ(both.method->name(), "lb+sh");
  EXPECT_EQ(both.options.get<int>("sh.order"), 5);
  EXPECT_EQ(both.options.get<int>("lb.visibility_rank"), 50);
  EXPECT_EQ(load_both("sh").method.get(), &other);
  EXPECT_EQ(load_both("[lb]", "methods=[lb, sh]").method->name(), "lb+sh");
  EXPECT_THROW(load_both("[]"), UserError);
  EXPECT_THROW(load_both("[sh, sh]"), UserError);
  EXPECT_THROW(load_both("[sh, drt]"), UserError);
  EXPECT_THROW(load_both("{lb: 1}"), UserError);
}

TEST_F(ConfigTest, PathsAreRelativeToWhereTheyAreGiven) {
  const BakeConfig file = load("scene: s/a.glb\noutput: ../out/b/\n");
  EXPECT_EQ(file.scene, folder_ / "s/a.glb");
  EXPECT_EQ(file.output, folder_.parent_path() / "out/b");
  const BakeConfig line = load("scene: s/a.glb\noutput: x\n", {{"scene=c.glb"}, "d"});
  EXPECT_EQ(line.scene, fs::current_path() / "c.glb");
  EXPECT_EQ(line.output, fs::current_path() / "d");
  EXPECT_EQ(load("scene: s/a.glb\n").output, fs::current_path() / "out/a");
  EXPECT_EQ(load("scene: a.glb\n", {{"output=e/f"}, {}}).output, fs::current_path() / "e/f");
}

TEST_F(ConfigTest, TheCommandLineOverridesAndTheLastOneWins) {
  const BakeConfig config =
      load("scene: a.glb\nseed: 3\n", {{"seed=4", "lb.visibility_rank=9", "seed=5"}, {}});
  EXPECT_EQ(config.options.get<int>("seed"), 5);
  EXPECT_EQ(config.options.get<int>("lb.visibility_rank"), 9);
  EXPECT_EQ(load("scene: a.glb\n", {{"samples.start=[0, 1, 0]"}, {}})
                .options.get<std::vector<double>>("samples.start")[1],
            1.0);
}

TEST_F(ConfigTest, SamplingMayStartInSeveralRooms) {
  const auto start = [&](const std::string& points) {
    return load("scene: a.glb\nsamples: {start: " + points + "}\n").options.at("samples.start");
  };
  EXPECT_EQ(start("[[1, 2.5, -3], [4, 5, 6]]"),
            nlohmann::json::parse("[[1.0, 2.5, -3.0], [4.0, 5.0, 6.0]]"));
  for (const char* points : {"[[1, 2], [3, 4, 5]]", "[]", "[[]]", "[[1, 2, 3], 4]", "[[[1, 2, 3]]]",
                             "[1, 2, 3, 4]", "[[1, 2, 3], [4, 5, x]]"}) {
    EXPECT_THAT(error(std::string("scene: a.glb\nsamples: {start: ") + points + "}\n"),
                HasSubstr("points [[x, y, z], ...]"))
        << points;
  }
  std::string many = "[";
  for (std::size_t i = 0; i <= kMostGivenPoints; ++i) many += "[1, 2, 3],";
  EXPECT_NE(error("scene: a.glb\nsamples: {start: " + many + "]}\n"), "");
}

TEST_F(ConfigTest, SpacingStandsInForCount) {
  const BakeConfig spacing = load("scene: a.glb\nsamples: {spacing: 0.1}\n");
  EXPECT_FALSE(spacing.options.is_set("samples.count"));
  EXPECT_DOUBLE_EQ(spacing.options.get<double>("samples.spacing"), 0.1);
  const BakeConfig other =
      load("scene: a.glb\nsamples: {count: 500}\n", {{"samples.spacing=0.2"}, {}});
  EXPECT_FALSE(other.options.is_set("samples.count"));
  EXPECT_THAT(error("scene: a.glb\nsamples: {count: 500, spacing: 0.1}\n"), HasSubstr("give one"));
  EXPECT_THAT(error("scene: a\n", {{"samples.count=500", "samples.spacing=1"}, {}}),
              HasSubstr("give one"));
}

TEST_F(ConfigTest, UnknownKeysNameLineAndNearestKey) {
  EXPECT_THAT(error("scene: a.glb\nlb:\n  solver: gather\n  visibilty_rank: 4\n"),
              AllOf(HasSubstr("a.yaml:4"), HasSubstr("\"lb.visibilty_rank\""),
                    HasSubstr("\"lb.visibility_rank\"")));
  EXPECT_THAT(error("scen: a.glb\n"), AllOf(HasSubstr("a.yaml:1"), HasSubstr("\"scene\"")));
  EXPECT_THAT(error("scene: a\nsample: {count: 3}\n"), HasSubstr("\"samples"));
  EXPECT_THAT(error("scene: a\n", {{"sed=3"}, {}}),
              AllOf(HasSubstr("--set sed=3"), HasSubstr("\"seed\"")));
  EXPECT_THAT(error("scene: a\n<<: {seed: 3}\n"), HasSubstr("unknown key"));
}

TEST_F(ConfigTest, DuplicateKeysNameBothLines) {
  EXPECT_THAT(error("scene: a.glb\nseed: 1\nseed: 2\n"),
              AllOf(HasSubstr("a.yaml:3"), HasSubstr("duplicate"), HasSubstr("line 2")));
  EXPECT_THAT(error("scene: a\nlb: {solver: gather}\nlb:\n  solver: gather\n"),
              HasSubstr("duplicate"));
  EXPECT_THAT(error("scene: a\nlb:\n  solver: gather\n  solver: photons\n"),
              AllOf(HasSubstr("a.yaml:4"), HasSubstr("duplicate")));
}

TEST_F(ConfigTest, WrongTypesAndRangesSayWhatIsExpected) {
  const auto with = [&](const std::string& line) { return error("scene: a.glb\n" + line + "\n"); };
  EXPECT_THAT(with("seed: many"), AllOf(HasSubstr("a.yaml:2"), HasSubstr("whole number")));
  EXPECT_THAT(with("seed: 1.5"), HasSubstr("whole number"));
  EXPECT_THAT(with("seed: '1'"), HasSubstr("whole number"));
  EXPECT_THAT(with("seed: -1"), HasSubstr("from 0"));
  EXPECT_THAT(with("seed:"), HasSubstr("not empty"));
  EXPECT_THAT(with("seed: [1]"), HasSubstr("whole number"));
  EXPECT_THAT(with("seed: {a: 1}"), HasSubstr("whole number"));
  EXPECT_THAT(with("seed: 99999999999999999999999"), HasSubstr("whole number"));
  EXPECT_THAT(with("samples: {count: -5}"), HasSubstr("samples.count must be a whole number"));
  EXPECT_THAT(with("samples: {start: [1, 2]}"), HasSubstr("point [x, y, z] or auto"));
  EXPECT_THAT(with("samples: {start: [1, 2, x]}"), HasSubstr("point"));
  EXPECT_THAT(with("samples: {start: here}"), HasSubstr("point"));
  EXPECT_THAT(with("samples: 5"), HasSubstr("keys of its own"));
  EXPECT_THAT(with("transport: {tolerance: .nan}"), HasSubstr("a number from"));
  EXPECT_THAT(with("transport: {tolerance: .inf}"), HasSubstr("a number from"));
  EXPECT_THAT(with("transport: {bounces: some}"), HasSubstr("or auto"));
  EXPECT_THAT(with("compression: {bits: 12}"), HasSubstr("8 or 16"));
  EXPECT_THAT(with("store: {keep: some}"), HasSubstr("all or needed"));
  EXPECT_THAT(with("lb: {solver: magic}"), HasSubstr("gather or photons"));
  EXPECT_THAT(with("methods: [sh]"), HasSubstr("one of: lb"));
  EXPECT_THAT(with("methods: [lb, lb]"), HasSubstr("one of: lb"));
  EXPECT_THAT(with("output: [a]"), HasSubstr("must be a path"));
}

TEST_F(ConfigTest, FilesThatAreNoConfigurationAreRefused) {
  EXPECT_THAT(error_of(folder_ / "none.yaml"), HasSubstr("no such configuration"));
  EXPECT_THAT(error_of(folder_), HasSubstr("is a folder or a device, not a file"));
  EXPECT_THAT(error(""), HasSubstr("is empty"));
  EXPECT_THAT(error("# only a comment\n"), HasSubstr("is empty"));
  EXPECT_THAT(error("- a\n- b\n"), HasSubstr("keys and values"));
  EXPECT_THAT(error("just words\n"), HasSubstr("keys and values"));
  EXPECT_THAT(error("scene: a\n---\nscene: b\n"), HasSubstr("several YAML documents"));
  EXPECT_THAT(error("scene: [a\nb: }\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error("scene: *nobody\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error(std::string("scene: a\0b\n", 11)), HasSubstr("not a text file"));
  EXPECT_THAT(error("? [a, b]\n: c\n"), HasSubstr("single word"));
  EXPECT_THAT(error("seed: 3\n"), HasSubstr("\"scene\" is missing"));
  EXPECT_THAT(error(std::string(100000, '[')), HasSubstr("not valid YAML"));
  EXPECT_THAT(error("scene: " + std::string(2 << 20, 'a')), HasSubstr("1 MiB"));
}

TEST_F(ConfigTest, AnchorBombsStaySmall) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 40; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last + ", " + last +
            ", " + last + "]\n";
  }
  EXPECT_THAT(error(bomb), HasSubstr("unknown key"));
  EXPECT_THAT(error(bomb.substr(0, 0) + "seed: &a [*a]\n"), HasSubstr("seed"));
}

TEST_F(ConfigTest, SettingsThatAreNoneAreRefused) {
  EXPECT_THAT(error("scene: a\n", {{"seed"}, {}}), HasSubstr("key.path=value"));
  EXPECT_THAT(error("scene: a\n", {{"=3"}, {}}), HasSubstr("key.path=value"));
  EXPECT_THAT(error("scene: a\n", {{"seed="}, {}}), HasSubstr("not empty"));
  EXPECT_THAT(error("scene: a\n", {{"samples.start=[1, 2"}, {}}), HasSubstr("not valid YAML"));
  EXPECT_THAT(error("scene: a\n", {{"samples=3"}, {}}), HasSubstr("is a section"));
}

TEST(EditDistance, CountsEdits) {
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("count", "count"), 0U);
  EXPECT_EQ(edit_distance("cuont", "count"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Help, ListsEveryOptionWithDefaultRangeAndSource) {
  const FakeMethod method;
  const std::string help = describe_options({&method});
  for (const OptionSpec& spec : shared_options()) EXPECT_THAT(help, HasSubstr(spec.key));
  EXPECT_THAT(help, HasSubstr("lb.visibility_rank"));
  EXPECT_THAT(help, HasSubstr("default 50; a whole number from 1 to 1000; source: eq. 9"));
  EXPECT_THAT(help, HasSubstr("default gather; gather or photons"));
}

}  // namespace
}  // namespace prt
