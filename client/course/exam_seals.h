#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/course/seal.h"
#include "client/course/trial_table.h"

namespace palpate {

inline TrialKey KeyOf(const Roll::Entry& entry) {
  return {entry.person, entry.exercise, entry.n};
}

/// Seals the trials of an exam and keeps its roll, which alone says what may still be sealed: what
/// a former process left behind is sealed as far as a mark of that process covers it, and nothing
/// else is, whatever course.sqlite or the folder say.  Each seal names the one before it.
/// Thread contract: one thread; it makes marks in one of its own, which no disk and no seal holds
/// up, and seals in another.
class ExamSeals {
 public:
  using Key = TrialKey;
  /// What became of a trial that was to be sealed.
  struct Done {
    Key key;
    std::string text = {};  ///< of its seal; empty: it is lost
    std::string lost = {};  ///< why
    bool is_rest = false;   ///< a former process began it: it ends here, not whole
  };

  explicit ExamSeals(std::string folder);
  ~ExamSeals();

  /// The newest exam's.
  const Roll& roll() const { return roll_; }
  /// Why the roll cannot be used, so that nothing of the exam is sealed any more; empty: it can.
  const std::string& trouble() const { return trouble_; }
  const Roll::Entry* Find(const Key& key) const;

  /// Begins the roll of a new exam.  Throws Error, also if there is a roll of that name that is in
  /// use.
  void Open(const Roll& roll);
  /// Takes up the roll that another process has left.  @param roll  what it must agree with.
  void TakeUp(const Roll& roll);
  /// Changes the roll, and seals it anew.  Throws Error, and then changes nothing.
  void Change(const std::function<void(Roll&)>& change);
  /// Enters a trial that begins now.  Throws Error.
  void Begin(const Roll::Entry& entry, std::int64_t now_s);
  /// Tells the time for marks.  Throws what the last ones failed of.
  void Poll(std::int64_t now_s);
  /// Returns whether another trial can be sealed now.
  bool is_idle() const { return !sealing_.valid(); }
  /// Begins to seal a trial, whose recorder has ended.  @pre is_idle()
  /// @param seal  without hashes; of a trial that another process began, the end is filled in, too.
  void BeginToSeal(const Seal& seal);
  /// Returns the trial that was sealed, or found lost, and has entered it in the roll.  Throws
  /// Error if that failed; it may then be tried again.
  std::optional<Done> Take();

  static constexpr const char* kKilled = "the gateway was killed";

 private:
  /// A trial that this process began.
  struct Growing {
    std::mutex guard;  // of what follows
    Mark mark;
    std::string file;
    std::unique_ptr<GrowingHash> hash;  // none: there is no recording yet
  };

  std::string FileOf(const Roll& roll) const;
  std::string StemOf(const Key& key) const;
  void Write(const Roll& roll) const;
  void WriteMark(const Mark& mark) const;
  void ReadOn(Growing& growing, std::int64_t now_s) const;
  /// Marks trials that run, some twenty times a second, until this ends.
  void MarkOn();
  Done SealWhole(Seal seal, Growing& growing) const;
  Done SealRest(Seal seal) const;
  /// Returns a seal of that trial that a former process made as the next one.
  std::optional<Done> FormerSealOf(const Seal& seal) const;
  /// Returns the trial's mark.  Throws Error if there is none, or another's.
  Mark MarkOf(const Seal& seal) const;
  /// Cuts a recording off after what the mark covers.  Returns false, and does nothing, while its
  /// recorder still writes.  Throws Error if it is not the one that was marked.
  bool CutToMark(const std::string& file, const Mark& mark) const;
  Done Sealed(const Seal& seal) const;

  const std::string folder_;
  const SealKey key_;
  Roll roll_;
  std::string trouble_;
  std::atomic<std::int64_t> now_s_ = 0;
  std::mutex guard_;  // of the next four
  std::condition_variable wake_;
  std::map<Key, std::shared_ptr<Growing>> growing_;
  std::exception_ptr trouble_of_marks_;
  bool ends_ = false;
  std::future<Done> sealing_;
  std::thread marking_;  // the last member: it uses the others
};

}  // namespace palpate
