// z-tests of many estimates at once.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace prt::test {

/// Chance that a correct program fails a whole family of comparisons. Seeds are fixed, so this is
/// the chance once, when a seed is chosen, not on every run.
inline constexpr double kFamilyWiseError = 1e-3;
/// Values that agree exactly up to float rounding pass whatever their variance, which may be 0.
inline constexpr double kRounding = 2e-5;

/// Two-sided p-value of a standard normal z.
inline double p_value(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

/// Collects estimates with their truth; check() applies Šidák's correction for their number.
class ZFamily {
 public:
  void add(const std::string& what, double mean, double standard_error, double truth) {
    entries_.push_back({what, mean, standard_error, truth});
  }
  /// Estimate from independent replicates.
  void add(const std::string& what, const std::vector<double>& replicates, double truth) {
    const auto n = static_cast<double>(replicates.size());
    double mean = 0.0, squares = 0.0;
    for (double r : replicates) mean += r / n;
    for (double r : replicates) squares += (r - mean) * (r - mean);
    add(what, mean, std::sqrt(squares / (n - 1.0) / n), truth);
  }
  void check() const {
    const double alpha =
        1.0 - std::pow(1.0 - kFamilyWiseError, 1.0 / static_cast<double>(entries_.size()));
    for (const auto& e : entries_) {
      const double off = std::abs(e.mean - e.truth);
      if (off <= kRounding * std::abs(e.truth)) continue;
      EXPECT_GE(p_value(off / e.standard_error), alpha)
          << e.what << ": " << e.mean << " +- " << e.standard_error << ", truth " << e.truth
          << ", z " << (e.mean - e.truth) / e.standard_error;
    }
  }

 private:
  struct Entry {
    std::string what;
    double mean, standard_error, truth;
  };
  std::vector<Entry> entries_;
};

}  // namespace prt::test
