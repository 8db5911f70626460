#include "methods/options.h"

#include <gtest/gtest.h>

#include <set>

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

}  // namespace
}  // namespace prt
