#pragma once

#include "common/quoted.h"
