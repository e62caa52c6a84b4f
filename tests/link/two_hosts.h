#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/link/bad_wire.h"
#include "tests/support/program.h"

namespace palpate::test {

/// Two hosts, as network namespaces of this one, with a bad wire between them.  In each, the
/// interface kLan has an address.  They end with the processes in them, so nothing is left behind.
class TwoHosts {
 public:
  static constexpr const char* kLan = "lan";
  static constexpr const char* kAddress[] = {"10.37.0.1", "10.37.0.2"};

  /// Why this machine allows no such hosts: a missing right or program.  Empty: it does, and then
  /// nothing that follows may fail.
  static std::string WhyNot();

  /// Throws Error with the reason if a step fails.
  explicit TwoHosts(const LinkConditions& each_way);

  std::unique_ptr<Program> Start(int host, const std::string& file,
                                 const std::vector<std::string>& arguments) const;
  BadWire& wire() { return *wire_; }

 private:
  std::unique_ptr<Program> holder_[2];  // keeps its namespace
  std::unique_ptr<BadWire> wire_;
};

}  // namespace palpate::test
