// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/checkpoint.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include "dem/base/checksum.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/hdf5_image.hpp"
#include "dem/io/whole_file.hpp"

namespace grus::dem {
namespace {

/// Raised where fields change their meaning, or what is kept beside the states; `layout_of_states` tells other fields.
constexpr std::uint64_t format_version = 41;

/// True where the last eight bytes of a file are the checksum of all before: HDF5 does not mind them, and leaves gaps
/// that no checksum of its datasets would reach.
bool sealed(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string piece(std::size_t{1} << 20, '\0'), ahead;  // ahead: the last bytes so far, which may be the seal
  std::uint64_t h = checksum({}), seal = 0;
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0) {
    ahead.append(piece, 0, static_cast<std::size_t>(in.gcount()));
    if (ahead.size() < sizeof seal) continue;
    h = checksum(std::string_view(ahead).substr(0, ahead.size() - sizeof seal), h);
    ahead.erase(0, ahead.size() - sizeof seal);
  }
  if (ahead.size() != sizeof seal) return false;
  std::memcpy(&seal, ahead.data(), sizeof seal);
  return seal == h;
}

void write(hid_t file, const char* name, hid_t type, std::size_t count, const void* data) {
  const hsize_t size = count;
  const Handle space{H5Screate_simple(1, &size, nullptr), H5Sclose};
  const Handle set{H5Dcreate2(file, name, type, space.id, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose};
  if (set.id < 0 || (count > 0 && H5Dwrite(set.id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0))
    throw std::runtime_error(fmt::format("HDF5: cannot write {}", name));
}

/// Bytes that grow by what is appended: all the parts, of which one at a time is held.
class Growing {
public:
  Growing(hid_t file, const char* name) {
    const hsize_t none = 0, any = H5S_UNLIMITED, chunk = hsize_t{1} << 18;
    const Handle space{H5Screate_simple(1, &none, &any), H5Sclose};
    const Handle how{must(H5Pcreate(H5P_DATASET_CREATE), "make properties"), H5Pclose};
    H5Pset_chunk(how.id, 1, &chunk);
    set_.id =
        must(H5Dcreate2(file, name, H5T_NATIVE_UINT8, space.id, H5P_DEFAULT, how.id, H5P_DEFAULT), "make a column");
  }
  void append(const std::string& bytes) {
    if (bytes.empty()) return;
    const hsize_t from = size_, more = bytes.size();
    size_ += more;
    const bool longer = H5Dset_extent(set_.id, &size_) >= 0;
    const Handle here{H5Screate_simple(1, &more, nullptr), H5Sclose}, there{H5Dget_space(set_.id), H5Sclose};
    H5Sselect_hyperslab(there.id, H5S_SELECT_SET, &from, nullptr, &more, nullptr);
    if (!longer || H5Dwrite(set_.id, H5T_NATIVE_UINT8, here.id, there.id, H5P_DEFAULT, bytes.data()) < 0)
      throw std::runtime_error("HDF5: cannot write the parts of a checkpoint");
  }
  hsize_t size() const { return size_; }

private:
  Handle set_{-1, H5Dclose};
  hsize_t size_ = 0;
};

/// `room`: bytes of the file; what is written is neither packed nor spread thin, so no column holds more. A column that
/// says so would only take memory.
template <class C>
bool read(hid_t file, const char* name, hid_t type, std::size_t room, C& into) {
  const Handle set{H5Dopen2(file, name, H5P_DEFAULT), H5Dclose};
  if (set.id < 0) return false;
  const Handle space{H5Dget_space(set.id), H5Sclose};
  const hssize_t count = H5Sget_simple_extent_npoints(space.id);
  const Handle stored{H5Dget_type(set.id), H5Tclose};
  if (count < 0 || stored.id < 0 || H5Tequal(stored.id, type) <= 0) return false;
  if (static_cast<std::size_t>(count) > room / H5Tget_size(type)) return false;
  into.resize(static_cast<std::size_t>(count));
  return count == 0 || H5Dread(set.id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, into.data()) >= 0;
}

}  // namespace

void write_checkpoint(const std::string& path, const std::string& about,
                      const std::function<void(const TakePart&)>& parts) {
  std::string image = hdf5_image([&](hid_t file) {
    std::vector<std::uint64_t> offsets{0};
    const std::vector<std::uint64_t> head{format_version, layout_of_states()};
    Growing packed(file, "parts");
    parts([&](const std::string& part) {
      packed.append(part);
      offsets.push_back(packed.size());
    });
    write(file, "head", H5T_NATIVE_UINT64, head.size(), head.data());
    write(file, "about", H5T_NATIVE_UINT8, about.size(), about.data());
    write(file, "offsets", H5T_NATIVE_UINT64, offsets.size(), offsets.data());
  });
  const std::uint64_t seal = checksum(image);
  write_whole(path, image.append(reinterpret_cast<const char*>(&seal), sizeof seal));
}

Checkpoint read_checkpoint(const std::string& path) {
  auto refuse = [&](const std::string& why) { throw InputError(fmt::format("{}: {}", path, why)); };
  if (::access(path.c_str(), F_OK) != 0) refuse("no checkpoint to resume from");
  begin_hdf5();
  const Handle file{H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  if (file.id < 0) refuse("checkpoint is damaged: not a whole HDF5 file");
  std::vector<std::uint64_t> head, offsets;
  std::string packed;
  Checkpoint c;
  std::error_code none;
  const std::size_t room = std::filesystem::file_size(path, none);
  if (none) refuse("cannot read: " + none.message());
  if (!read(file.id, "head", H5T_NATIVE_UINT64, room, head) || head.size() < 2) refuse("not a checkpoint of Grus");
  if (head[0] != format_version)
    refuse(fmt::format("checkpoint of format {}, this version reads {}: run again from the start", head[0],
                       format_version));
  if (head[1] != layout_of_states())
    refuse("checkpoint of a build with another data layout: resume with the program that wrote it");
  if (!sealed(path)) refuse("checkpoint is damaged: its checksum does not match");
  if (!read(file.id, "about", H5T_NATIVE_UINT8, room, c.about) ||
      !read(file.id, "offsets", H5T_NATIVE_UINT64, room, offsets) ||
      !read(file.id, "parts", H5T_NATIVE_UINT8, room, packed))
    refuse("checkpoint is damaged: a part is missing, or larger than the file");
  if (offsets.empty() || offsets.front() != 0 || offsets.back() != packed.size())
    refuse("checkpoint is damaged: its offsets do not match");
  for (std::size_t k = 0; k + 1 < offsets.size(); ++k) {
    if (offsets[k] > offsets[k + 1] || offsets[k + 1] > packed.size())
      refuse("checkpoint is damaged: its offsets do not match");
    c.parts.push_back(packed.substr(offsets[k], offsets[k + 1] - offsets[k]));
  }
  return c;
}

}  // namespace grus::dem
