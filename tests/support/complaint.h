#pragma once

#include <string>

#include "common/error.h"

namespace palpate::test {

/// Returns the message of the Error that `work` throws; "no complaint" if it throws none.
template <class Work>
std::string ComplaintOf(Work work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no complaint";
}

}  // namespace palpate::test
