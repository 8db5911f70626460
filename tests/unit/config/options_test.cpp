#include "methods/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"

namespace prt {
namespace {

TEST(SharedOptions, DefaultsFitTheirOwnTable) {
  std::set<std::string> keys;
  for (const OptionSpec& spec : shared_options()) {
    EXPECT_TRUE(keys.insert(spec.key).second) << spec.key;
    EXPECT_FALSE(spec.meaning.empty()) << spec.key;
    EXPECT_FALSE(spec.source.empty()) << spec.key;
    if (spec.fallback.is_null()) continue;
    EXPECT_NO_THROW(check_option(spec, spec.fallback, "table"));
  }
}

TEST(OptionValues, AnOptionInNoTableIsABug) {
  OptionValues values;
  values.set("a", nullptr);
  EXPECT_FALSE(values.is_set("a"));
  EXPECT_THROW((void)values.at("b"), std::logic_error);
}

TEST(CheckOption, BoundsAreInclusive) {
  const OptionSpec spec{"k", OptionSpec::Type::kNumber, 0.5, 0.0, 1.0, {}, "", "m", "s"};
  EXPECT_NO_THROW(check_option(spec, 0.0, "x"));
  EXPECT_NO_THROW(check_option(spec, 1.0, "x"));
  EXPECT_THROW(check_option(spec, 1.0001, "x"), UserError);
  EXPECT_THROW(check_option(spec, "auto", "x"), UserError);
}

TEST(CheckOption, ACountOfDirectionsThatFormsNoGridIsRefusedWithOneThatIsTaken) {
  const std::vector<OptionSpec> table = shared_options();
  const auto spec = std::ranges::find(table, "rays.directions", &OptionSpec::key);
  ASSERT_NE(spec, table.end());
  EXPECT_NO_THROW(check_option(*spec, 2016, "x"));
  for (int count = static_cast<int>(spec->minimum); count < 600; ++count) {
    try {
      check_option(*spec, count, "x");
    } catch (const UserError& error) {
      const std::string text = error.what();
      const std::string advice = text.substr(text.find("use ") + 4);
      EXPECT_NO_THROW(check_option(*spec, std::stoi(advice), "x")) << text;
    }
  }
  EXPECT_THROW(check_option(*spec, 512, "x"), UserError);
}

}  // namespace
}  // namespace prt
