// SPDX-License-Identifier: LGPL-3.0-or-later
// A macro problem that lies on one rank, or on all: what its owners decide and do together.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/bvp/on_all_ranks.hpp"
#include "apps/bvp/patience.hpp"

namespace grus::app {

/// Of a problem on one rank every member does what is asked on this rank alone. Of one that is spread, all ranks must
/// call the same members in the same order.
class AcrossRanks {
public:
  AcrossRanks(const fem::Session& session, bool spread) : session_(session), spread_(spread) {}

  bool spread() const { return spread_; }
  bool leads() const { return !spread_ || session_.rank() == 0; }
  int rank() const { return spread_ ? session_.rank() : 0; }
  int ranks() const { return spread_ ? session_.ranks() : 1; }
  MPI_Comm comm() const { return spread_ ? MPI_COMM_WORLD : MPI_COMM_SELF; }

  /// What may fail on any rank; then all throw the first one's error. `part` asks nothing of other ranks.
  template <class F>
  void together(F&& part) {
    if (!spread_) return part();
    agreed_ = true;
    on_all_ranks(session_, [&] {
      const Patience::Work by_itself = work();
      part();
    });
    agreed_ = false;
  }
  /// What rank 0 does for all, such as to write.
  template <class F>
  void lead(F&& part) {
    together([&] {
      if (leads()) part();
    });
  }
  /// Asked once of an error that is being handled: true where all ranks handle it. Of another one the rest know
  /// nothing.
  bool agreed() { return !spread_ || std::exchange(agreed_, false); }

  /// Bits that are set on any rank.
  int any(int bits) const;
  /// What the first rank says whose text is not empty; empty: none does.
  std::string first(const std::string& text) const;
  /// On rank 0 the texts of all ranks, one after the other; elsewhere nothing.
  std::string all_texts(const std::string& text) const;
  /// The numbers of all ranks, in their order.
  std::vector<double> all_numbers(double mine) const;
  /// Bytes go `to` a rank, and others come `from` one, to which this is `to`.
  std::string swap(std::string bytes, int to, int from) const;
  /// Rank `from` tells all the others.
  void tell(int from, std::string& bytes) const;

  /// From now on, as long as there is something to wait for: who stops answering ends all ranks, by `give_up`.
  void lose_patience_after(double seconds, std::function<void(const std::string&)> give_up) {
    if (ranks() > 1) patience_ = std::make_unique<Patience>(seconds, std::move(give_up));
  }
  void be_patient() { patience_.reset(); }
  void got_on() const {
    if (patience_) patience_->got_on();
  }
  /// What this rank does by itself, as long as the answer lives.
  Patience::Work work() const { return Patience::Work(patience_.get()); }

private:
  const fem::Session& session_;
  bool spread_, agreed_ = false;
  std::unique_ptr<Patience> patience_;
};

}  // namespace grus::app
