// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/instructions.hpp"

#include <csignal>

namespace voxshell {

struct InstructionCount::Before {
    struct sigaction action;
    sigset_t mask;
};

#if defined(__x86_64__)

namespace {

constexpr unsigned long long trap_flag = 0x100;

volatile std::uint64_t step_count;
volatile std::uint64_t next_instruction;

/// After each instruction. A repeated one traps after each round and stays where it is.
extern "C" void step(int, siginfo_t *, void *context)
{
    const auto next =
        static_cast<std::uint64_t>(static_cast<const ucontext_t *>(context)->uc_mcontext.gregs[REG_RIP]);
    if (next != next_instruction) step_count = step_count + 1;
    next_instruction = next;
}

[[gnu::noinline]] void nothing(void *) {}

} // namespace

InstructionCount::InstructionCount() : before_(std::make_unique<Before>())
{
    struct sigaction action = {};
    action.sa_sigaction = step;
    action.sa_flags = SA_SIGINFO;
    sigemptyset(&action.sa_mask);
    sigset_t trap;
    sigemptyset(&trap);
    sigaddset(&trap, SIGTRAP);
    sigaction(SIGTRAP, &action, &before_->action);
    pthread_sigmask(SIG_UNBLOCK, &trap, &before_->mask);
    around_ = steps(nothing, nullptr);
    if (around_ < 4) why_not_ = "this machine does not let a program step through itself"; // an emulator's
}

InstructionCount::~InstructionCount()
{
    pthread_sigmask(SIG_SETMASK, &before_->mask, nullptr);
    sigaction(SIGTRAP, &before_->action, nullptr);
}

/// The same instructions around every call, whatever is called.
[[gnu::noinline]] std::uint64_t InstructionCount::steps(void (*work)(void *), void *user)
{
    step_count = 0;
    next_instruction = 0;
    __builtin_ia32_writeeflags_u64(__builtin_ia32_readeflags_u64() | trap_flag);
    work(user);
    __builtin_ia32_writeeflags_u64(__builtin_ia32_readeflags_u64() & ~trap_flag);
    return step_count;
}

std::uint64_t InstructionCount::so_far() const
{
    return step_count;
}

void InstructionCount::stepping(bool counts)
{
    const unsigned long long flags = __builtin_ia32_readeflags_u64() & ~trap_flag;
    __builtin_ia32_writeeflags_u64(flags | (counts ? trap_flag : 0));
}

std::uint64_t InstructionCount::counted(void (*work)(void *), void *user)
{
    return why_not_.empty() ? steps(work, user) - around_ : 0;
}

#else

InstructionCount::InstructionCount()
    : why_not_("this processor has no flag by which a program steps through itself")
{
}

InstructionCount::~InstructionCount() = default;

std::uint64_t InstructionCount::counted(void (*)(void *), void *)
{
    return 0;
}

std::uint64_t InstructionCount::so_far() const
{
    return 0;
}

void InstructionCount::stepping(bool) {}

#endif

} // namespace voxshell
