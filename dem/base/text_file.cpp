// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/base/text_file.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "dem/base/error.hpp"

namespace grus::dem {
namespace {

void append_utf8(std::string& text, std::uint32_t c) {
  const auto byte = [&](std::uint32_t v) { text += static_cast<char>(static_cast<unsigned char>(v)); };
  if (c < 0x80) return byte(c);
  if (c < 0x800) return byte(0xC0 | c >> 6), byte(0x80 | (c & 0x3F));
  if (c < 0x10000) return byte(0xE0 | c >> 12), byte(0x80 | (c >> 6 & 0x3F)), byte(0x80 | (c & 0x3F));
  byte(0xF0 | c >> 18), byte(0x80 | (c >> 12 & 0x3F)), byte(0x80 | (c >> 6 & 0x3F)), byte(0x80 | (c & 0x3F));
}

/// From UTF-16 without its mark; what is no character becomes U+FFFD.
std::string utf8_of(const std::string& bytes, bool big) {
  std::string text;
  const auto unit = [&](std::size_t k) {
    const auto a = static_cast<unsigned char>(bytes[k]), b = static_cast<unsigned char>(bytes[k + 1]);
    return static_cast<std::uint32_t>(big ? a << 8 | b : b << 8 | a);
  };
  for (std::size_t k = 0; k + 1 < bytes.size(); k += 2) {
    std::uint32_t c = unit(k);
    const bool first = c >= 0xD800 && c < 0xDC00, paired = first && k + 3 < bytes.size() && unit(k + 2) >> 10 == 0x37;
    if (paired) c = 0x10000 + ((c & 0x3FF) << 10) + (unit(k + 2) & 0x3FF), k += 2;
    append_utf8(text, c >= 0xD800 && c < 0xE000 ? 0xFFFD : c);
  }
  return text;
}

}  // namespace

std::unique_ptr<std::istream> open_text(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return nullptr;
  auto in = std::make_unique<std::ifstream>(path, std::ios::binary);
  char head[4] = {};
  in->read(head, sizeof head);
  const std::string begin(head, static_cast<std::size_t>(in->gcount()));
  in->clear();
  for (const char* mark : {"\x1F\x8B", "PK\3\4", "BZh", "\3757zX", "\x28\xB5\x2F\xFD"})  // gzip, zip, bzip2, xz, zstd
    if (begin.starts_with(mark)) throw InputError(path + ": the file is compressed; unpack it first");
  if (begin.starts_with("\xFF\xFE") || begin.starts_with("\xFE\xFF")) {
    in->seekg(2);
    const std::string rest{std::istreambuf_iterator<char>(*in), {}};
    return std::make_unique<std::istringstream>(utf8_of(rest, begin[0] == '\xFE'));
  }
  in->seekg(begin.starts_with("\xEF\xBB\xBF") ? 3 : 0);
  return in->good() ? std::move(in) : nullptr;
}

}  // namespace grus::dem
