// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

std::string lower_ending(const fs::path &path)
{
    std::string ending = path.extension().string();
    for (char &c : ending)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return ending;
}

void add_folder(const fs::path &folder, BatchInputs &inputs)
{
    std::vector<std::string> found;
    inputs.folders.push_back(folder.string());
    for (auto at = fs::recursive_directory_iterator(folder); at != fs::recursive_directory_iterator(); ++at) {
        if (at->path().filename().string().starts_with('.')) {
            if (at->is_directory()) at.disable_recursion_pending();
            continue;
        }
        if (at->is_directory()) inputs.folders.push_back(at->path().string());
        if (at->is_regular_file() && format_of(at->path())) found.push_back(at->path().string());
    }
    if (found.empty())
        throw Failure(ExitCode::usage, folder.string(),
                      fmt::format("no {} in this folder", import_endings()));
    std::sort(found.begin(), found.end());
    for (const std::string &path : found)
        inputs.files.push_back(
            {path, fs::path(path).lexically_relative(folder).replace_extension("").generic_string(),
             format_of(path)});
}

} // namespace

BatchInputs batch_inputs(const std::vector<std::string> &arguments)
{
    BatchInputs all;
    std::vector<BatchInput> &inputs = all.files;
    for (const std::string &argument : arguments) {
        const fs::path path(argument);
        std::error_code error;
        if (fs::is_directory(path, error)) {
            add_folder(path, all);
            continue;
        }
        if (!format_of(path))
            throw Failure(ExitCode::usage, argument,
                          fmt::format("is neither a folder nor one of {}", import_endings()));
        inputs.push_back({argument, path.stem().string(), format_of(path)});
    }
    if (inputs.empty())
        throw Failure(ExitCode::usage, "", "nothing to convert: name files, folders or --filelist");
    std::map<std::string, std::size_t> uses;
    for (const BatchInput &input : inputs) ++uses[input.name];
    std::map<std::string, std::string> named;
    for (BatchInput &input : inputs) {
        if (uses[input.name] > 1) input.name.append(1, '_').append(lower_ending(input.path), 1);
        const auto [other, is_new] = named.emplace(input.name, input.path);
        if (!is_new)
            throw Failure(ExitCode::usage, input.path,
                          fmt::format("and {} would both write {}.voxmap: give the folder that holds both",
                                      other->second, input.name));
    }
    return all;
}

} // namespace voxshell
