#pragma once

#include "common/math/random.h"

namespace palpate::test {

using palpate::Random;

}  // namespace palpate::test
