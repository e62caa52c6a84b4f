#pragma once

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// How soon the kernel lets a real-time thread in: PREEMPT_RT, else its mode of preemption.
Finding CheckKernel(const HostFiles& host);
/// Whether the clock is read without a system call.
Finding CheckClockSource(const HostFiles& host);

}  // namespace palpate::doctor
