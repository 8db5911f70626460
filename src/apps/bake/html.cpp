#include "apps/bake/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace prt::html {

using nlohmann::json;

namespace {

constexpr const char* kDash = "–";

bool is_finite(const json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string text_of(const json& value) {
  if (value.is_null() || (value.is_number() && !is_finite(value))) return kDash;
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  constexpr auto kReplace = json::error_handler_t::replace;
  const std::string dumped = value.dump(-1, ' ', false, kReplace);
  // Dumped, so that bytes that are no UTF-8 are replaced; without the quotes.
  return escaped(value.is_string() ? json::parse(dumped).get<std::string>() : dumped);
}

std::string percent(const json& value) {
  return is_finite(value) ? fmt::format("{:.2f} %", 100.0 * value.get<double>()) : kDash;
}

double number(const json& object, const char* key, double fallback) {
  if (!object.is_object()) return fallback;
  const auto it = object.find(key);
  return it != object.end() && is_finite(*it) ? it->get<double>() : fallback;
}

std::string bar(double share, const char* kind) {
  return fmt::format(
      "<svg class=\"bar {}\" viewBox=\"0 0 100 8\" preserveAspectRatio=\"none\" "
      "aria-hidden=\"true\"><rect width=\"{:.2f}\" height=\"8\"/></svg>",
      kind, 100.0 * std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0));
}

std::string jpeg_address(const std::string& bytes) {
  static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out = "data:image/jpeg;base64,";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      three = three << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
    }
  }
  return out;
}

}  // namespace prt::html
