// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/finished_work.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace voxshell {
namespace {

constexpr const char *kind = "voxshell-study-state/1 ";

/// "NAME<tab>1 2 3" with its end; nothing for a line that is not that.
bool read_row(const std::string &line, std::string &name, std::vector<double> &numbers)
{
    const std::size_t tab = line.find('\t');
    if (tab == std::string::npos || line.empty() || line.back() != ';') return false;
    name = line.substr(0, tab);
    for (const char *at = line.c_str() + tab + 1; *at != ';';) {
        char *end = nullptr;
        numbers.push_back(std::strtod(at, &end));
        if (end == at) return false;
        at = *end == ' ' ? end + 1 : end;
    }
    return true;
}

} // namespace

FinishedWork::FinishedWork(const std::filesystem::path &file, const std::string &inputs) : file_(file)
{
    std::error_code error;
    made_folder_ = std::filesystem::create_directories(file.parent_path(), error);
    bool goes_on = false, is_whole = true;
    {
        std::ifstream stream(file, std::ios::binary);
        std::string line, name;
        goes_on = std::getline(stream, line) && line == kind + inputs;
        while (goes_on && std::getline(stream, line)) {
            std::vector<double> numbers;
            if (read_row(line, name, numbers))
                rows_[name] = std::move(numbers);
            else
                is_whole = false;
        }
        stream.clear();
    }
    found_ = rows_.size();
    stream_ = std::fopen(file.c_str(), goes_on ? "ab" : "wb");
    if (!stream_) throw Failure(ExitCode::system, file.string(), std::strerror(errno));
    if (!goes_on) fmt::print(stream_, "{}{}\n", kind, inputs);
    if (!is_whole) fmt::print(stream_, "\n"); // what was cut off stays a line of its own
    std::fflush(stream_);
}

FinishedWork::~FinishedWork()
{
    if (stream_) std::fclose(stream_);
}

const std::vector<double> *FinishedWork::find(const std::string &name) const
{
    const auto found = rows_.find(name);
    return found == rows_.end() ? nullptr : &found->second;
}

const std::vector<double> &FinishedWork::add(const std::string &name, std::vector<double> numbers)
{
    std::string line = name + '\t';
    for (std::size_t n = 0; n < numbers.size(); ++n) line += fmt::format("{}{}", n ? " " : "", numbers[n]);
    line += ";\n";
    if (std::fwrite(line.data(), 1, line.size(), stream_) != line.size() || std::fflush(stream_) != 0)
        throw Failure(ExitCode::system, file_.string(), std::strerror(errno));
    return rows_[name] = std::move(numbers);
}

void FinishedWork::remove()
{
    std::error_code error;
    std::filesystem::remove(file_, error);
    if (made_folder_) std::filesystem::remove(file_.parent_path(), error); // refuses unless it is empty
}

} // namespace voxshell
