// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/across_ranks.hpp"

#include <algorithm>
#include <cstdint>

namespace grus::app {
namespace {

constexpr std::uint64_t piece = 1u << 28;  // of a message: a count is an int
constexpr int text_tag = 11, swap_tag = 13;

}  // namespace

int AcrossRanks::any(int bits) const {
  int all = bits;
  if (spread_) MPI_Allreduce(&bits, &all, 1, MPI_INT, MPI_BOR, MPI_COMM_WORLD);
  return all;
}

std::string AcrossRanks::first(const std::string& text) const {
  if (!spread_) return text;
  const int mine = text.empty() ? session_.ranks() : session_.rank();
  int from = 0;
  MPI_Allreduce(&mine, &from, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (from == session_.ranks()) return {};
  std::string all = text;
  tell(from, all);
  return all;
}

std::string AcrossRanks::all_texts(const std::string& text) const {
  std::string all = rank() == 0 ? text : "";
  std::uint64_t size = text.size();
  if (rank() > 0) {
    MPI_Send(&size, 1, MPI_UINT64_T, 0, text_tag, MPI_COMM_WORLD);
    for (std::uint64_t at = 0; at < size; at += piece)
      MPI_Send(text.data() + at, static_cast<int>(std::min(size - at, piece)), MPI_CHAR, 0, text_tag, MPI_COMM_WORLD);
  }
  for (int r = 1; r < ranks() && rank() == 0; ++r) {
    MPI_Recv(&size, 1, MPI_UINT64_T, r, text_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    const std::uint64_t before = all.size();
    all.resize(before + size);
    for (std::uint64_t at = 0; at < size; at += piece)
      MPI_Recv(all.data() + before + at, static_cast<int>(std::min(size - at, piece)), MPI_CHAR, r, text_tag,
               MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  }
  return all;
}

std::vector<double> AcrossRanks::all_numbers(double mine) const {
  std::vector<double> all(static_cast<std::size_t>(ranks()), mine);
  if (spread_) MPI_Allgather(&mine, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, MPI_COMM_WORLD);
  return all;
}

std::string AcrossRanks::swap(std::string bytes, int to, int from) const {
  if (to == rank()) return bytes;
  const std::uint64_t out = bytes.size();
  std::uint64_t in = 0;
  MPI_Sendrecv(&out, 1, MPI_UINT64_T, to, swap_tag, &in, 1, MPI_UINT64_T, from, swap_tag, MPI_COMM_WORLD,
               MPI_STATUS_IGNORE);
  std::string got(in, '\0');
  for (std::uint64_t at = 0; at < std::max(out, in); at += piece)
    MPI_Sendrecv(bytes.data() + std::min(at, out), static_cast<int>(std::min(out - std::min(at, out), piece)), MPI_CHAR,
                 at < out ? to : MPI_PROC_NULL, swap_tag, got.data() + std::min(at, in),
                 static_cast<int>(std::min(in - std::min(at, in), piece)), MPI_CHAR, at < in ? from : MPI_PROC_NULL,
                 swap_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return got;
}

void AcrossRanks::tell(int from, std::string& bytes) const {
  if (!spread_) return;
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, from, MPI_COMM_WORLD);
  bytes.resize(size);
  for (std::uint64_t at = 0; at < size; at += piece)
    MPI_Bcast(bytes.data() + at, static_cast<int>(std::min(size - at, piece)), MPI_CHAR, from, MPI_COMM_WORLD);
}

}  // namespace grus::app
