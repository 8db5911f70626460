// Pieces of a web page. Everything that is text of somebody else goes through escaped().
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace prt::html {

std::string escaped(const std::string& text);
/// Escaped; numbers with four digits; a dash for what is null or not finite.
std::string text_of(const nlohmann::json& value);
/// "4.10 %", a dash for what is no finite number.
std::string percent(const nlohmann::json& value);
/// The finite number `key` of an object, else `fallback`.
double number(const nlohmann::json& object, const char* key, double fallback);
/// A bar from 0 to `share` of its cell, in [0, 1]; `kind` is its CSS class.
std::string bar(double share, const char* kind);
/// A picture's bytes as the address of an <img>.
std::string jpeg_address(const std::string& bytes);

}  // namespace prt::html
