#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "client/viewer/class_room.h"
#include "client/viewer/gate.h"
#include "client/viewer/options.h"
#include "client/viewer/viewers.h"

namespace palpate {

/// Who may come in: the tokens of --tokens and those of the people of --course.
/// Thread contract: the network thread.
class Rights {
 public:
  /// @param take_back  takes the tool of a viewer whose token was taken back.
  /// Throws Error if a file is invalid.
  Rights(const ViewerOptions& options, Viewers& viewers,
         std::function<void(std::uint64_t viewer, const std::string& reason)> take_back);

  const Gate& gate() const { return gate_; }
  /// Null without --course.
  ClassRoom* class_room() const { return class_room_.get(); }
  /// The tokens of --tokens.
  Tokens listed() const { return listed_.value_or(Tokens()); }

  std::optional<Roster::Made> MakeFirstTeacher();
  /// The people of the course have changed.  Their tokens are valid from now on; connections whose
  /// token was removed or has another role end.
  void Renew() { Renew(listed_); }
  /// Reads --tokens and --course again, as Renew.  An invalid file changes nothing and is logged.
  /// Returns whether something may have changed.
  bool ReadAnew();

 private:
  /// Returns how many connections end.
  std::size_t Renew(std::optional<Tokens> listed);

  const ViewerOptions& options_;
  Viewers& viewers_;
  const std::function<void(std::uint64_t, const std::string&)> take_back_;
  std::unique_ptr<ClassRoom> class_room_;
  std::optional<Tokens> listed_;
  Gate gate_;
};

}  // namespace palpate
