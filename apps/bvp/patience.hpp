// SPDX-License-Identifier: LGPL-3.0-or-later
// Notices a rank that stops answering, which the others would wait for without end.
#pragma once

#include <mpi.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace grus::app {

/// Who has not answered, as `rank` knows it: rank 0 by those that have `told` it that they wait, if they can.
std::string silent_ranks(int rank, bool can_tell, const std::vector<std::uint8_t>& told);

/// A thread on each rank that looks whether the run gets on. A rank that waits in vain tells rank 0, which names those
/// that have not told; a rank that is stopped, or busy with work of its own, does not tell. Where rank 0 itself is
/// silent, the next rank speaks. Time in which a whole process is stopped does not count.
class Patience {
public:
  /// All ranks make one together. `give_up(text)` is called from the thread, and must not return.
  Patience(double seconds, std::function<void(const std::string&)> give_up);
  ~Patience();
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;

  void got_on() { ++steps_; }  // all ranks do, now and then
  /// While one lives, this rank works by itself and waits for no other.
  class Work {
  public:
    explicit Work(Patience* of) : of_(of) {
      if (of_) of_->works_ = true;
    }
    ~Work() {
      if (of_) of_->works_ = false, of_->got_on();
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

  private:
    Patience* of_;
  };

private:
  void look();
  void wait_in_vain();
  void hear();

  double seconds_;
  std::function<void(const std::string&)> give_up_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  bool tells_ = true;  // MPI may be asked by several threads
  std::atomic<std::uint64_t> steps_ = 0;
  std::atomic<bool> works_ = false;
  std::vector<std::uint8_t> told_;  // rank 0: who waits, too
  bool i_told_ = false;
  double quiet_ = 0;  // s without a step
  MPI_Request telling_ = MPI_REQUEST_NULL;
  std::mutex mutex_;
  std::condition_variable ends_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace grus::app
