// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/force_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace voxshell {
namespace {

using Complex = std::complex<double>;

constexpr double pi = std::numbers::pi;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double least_across = 1e-9; ///< share of the normal force that is rounding

Point apart(const Point &a, const Point &b, double scale)
{
    return {a[0] - scale * b[0], a[1] - scale * b[1], a[2] - scale * b[2]};
}

/// Decimation in time by the smallest prime factor: any length, fast where the factors are small.
void transform(const Complex *in, Complex *out, std::size_t count, std::size_t stride)
{
    if (count == 1) {
        *out = *in;
        return;
    }
    std::size_t factor = 2;
    while (count % factor) ++factor;
    const std::size_t part = count / factor;
    std::vector<Complex> parts(count);
    for (std::size_t f = 0; f < factor; ++f)
        transform(in + f * stride, parts.data() + f * part, part, stride * factor);
    for (std::size_t k = 0; k < count; ++k) {
        Complex sum = 0;
        for (std::size_t f = 0; f < factor; ++f) {
            sum +=
                std::polar(1.0, -2 * pi * static_cast<double>(f * k % count) / static_cast<double>(count)) *
                parts[f * part + k % part];
        }
        out[k] = sum;
    }
}

struct Spectrum {
    std::vector<double> power;
    double step; ///< [Hz]
    double all() const
    {
        double sum = 0;
        for (std::size_t n = 1; n < power.size(); ++n) sum += power[n];
        return sum;
    }
    double share(double from, double to) const
    {
        double in = 0;
        for (std::size_t n = 1; n < power.size(); ++n) {
            const double hz = step * static_cast<double>(n);
            if (hz > from && hz <= to) in += power[n];
        }
        return all() > 0 ? in / all() : nothing;
    }
};

/// Of the force's fluctuation: all three directions together. Hann's window keeps the power of what is
/// steady.
Spectrum fluctuation(const std::vector<ForceSample> &samples, double rate, bool periodic)
{
    const auto count = static_cast<double>(samples.size());
    Spectrum sum{std::vector<double>(samples.size() / 2 + 1, 0.0), rate / count};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> signal;
        double mean = 0;
        for (const ForceSample &s : samples) mean += s.force[axis] / count;
        for (std::size_t n = 0; n < samples.size(); ++n) {
            const double window =
                periodic ? 1
                         : (1 - std::cos(2 * pi * (static_cast<double>(n) + 0.5) / count)) / std::sqrt(1.5);
            signal.push_back(window * (samples[n].force[axis] - mean));
        }
        const std::vector<double> power = power_spectrum(signal);
        for (std::size_t n = 0; n < power.size(); ++n) sum.power[n] += power[n];
    }
    return sum;
}

/// The factor by which the ideal forces come nearest to those measured; 0 where there is no ideal.
double force_factor(const std::vector<ForceSample> &samples)
{
    double cross = 0, square = 0;
    for (const ForceSample &s : samples) {
        cross += dot(s.force, s.ideal_force);
        square += dot(s.ideal_force, s.ideal_force);
    }
    return square > 0 ? cross / square : 0;
}

/// Sizes of forces off those of the ideal, of the ideal's rms.
double magnitude_error(const std::vector<ForceSample> &samples)
{
    const double factor = force_factor(samples);
    double error = 0, square = 0;
    for (const ForceSample &s : samples) {
        const double ideal = factor * length(s.ideal_force), off = length(s.force) - ideal;
        error += off * off;
        square += ideal * ideal;
    }
    return factor > 0 ? std::sqrt(error / square) : nothing;
}

/// Force off its ideal: the angles, and both with torque by the best factor.
void against_ideal(const std::vector<ForceSample> &samples, double radius, double mean_size, ForceMetrics &m)
{
    double cross = 0, square = 0;
    std::vector<double> angles;
    for (const ForceSample &s : samples) {
        cross += dot(s.force, s.ideal_force) + dot(s.torque, s.ideal_torque) / (radius * radius);
        square += dot(s.ideal_force, s.ideal_force) + dot(s.ideal_torque, s.ideal_torque) / (radius * radius);
        const double size = length(s.force), ideal = length(s.ideal_force);
        if (size > 0 && ideal > 0) {
            angles.push_back(std::acos(std::clamp(dot(s.force, s.ideal_force) / (size * ideal), -1.0, 1.0)) *
                             180 / pi);
        }
    }
    const double factor = square > 0 ? cross / square : 0;
    double force = 0, torque = 0;
    for (const ForceSample &s : samples) {
        const Point f = apart(s.force, s.ideal_force, factor), t = apart(s.torque, s.ideal_torque, factor);
        force += dot(f, f);
        torque += dot(t, t);
    }
    const auto count = static_cast<double>(samples.size());
    m.torque_error = mean_size > 0 ? std::sqrt(torque / count) / (mean_size * radius) : nothing;
    m.wrench_error = factor > 0 ? std::sqrt((force + torque / (radius * radius)) / square) / factor : nothing;
    if (angles.empty()) {
        m.angle_mean = m.angle_p95 = m.angle_max = nothing;
        return;
    }
    std::sort(angles.begin(), angles.end());
    m.angle_mean = 0;
    for (const double angle : angles) m.angle_mean += angle / static_cast<double>(angles.size());
    m.angle_p95 = angles[static_cast<std::size_t>(0.95 * static_cast<double>(angles.size() - 1) + 0.5)];
    m.angle_max = angles.back();
}

} // namespace

std::vector<double> power_spectrum(const std::vector<double> &signal)
{
    if (signal.empty()) return {};
    const std::vector<Complex> in(signal.begin(), signal.end());
    std::vector<Complex> out(in.size());
    transform(in.data(), out.data(), in.size(), 1);
    std::vector<double> power;
    const auto count = static_cast<double>(in.size());
    for (std::size_t n = 0; n <= in.size() / 2; ++n) {
        const bool has_twin = n > 0 && 2 * n != in.size();
        power.push_back((has_twin ? 2 : 1) * std::norm(out[n]) / (count * count));
    }
    return power;
}

ShortTimeSpectrum error_spectrum(const std::vector<ForceSample> &samples, double rate, double radius,
                                 std::size_t window, std::size_t hop)
{
    ShortTimeSpectrum out{static_cast<double>(hop) / rate,
                          rate / static_cast<double>(window),
                          static_cast<double>(window) / (2 * rate),
                          {}};
    double cross = 0, ideal = 0;
    for (const ForceSample &s : samples) {
        cross += dot(s.force, s.ideal_force) + dot(s.torque, s.ideal_torque) / (radius * radius);
        ideal += dot(s.ideal_force, s.ideal_force) + dot(s.ideal_torque, s.ideal_torque) / (radius * radius);
    }
    const double factor = ideal > 0 ? cross / ideal : 0, count = static_cast<double>(window);
    const double square = factor * factor * ideal / static_cast<double>(samples.size());
    if (!(square > 0)) return out;
    const auto error = [&](const ForceSample &s, std::size_t axis) {
        return axis < 3 ? s.force[axis] - factor * s.ideal_force[axis]
                        : (s.torque[axis - 3] - factor * s.ideal_torque[axis - 3]) / radius;
    };
    for (std::size_t first = 0; first + window <= samples.size(); first += hop) {
        std::vector<double> sum(window / 2 + 1, 0.0);
        for (std::size_t axis = 0; axis < 6; ++axis) {
            std::vector<double> piece;
            for (std::size_t n = 0; n < window; ++n) {
                const double hann =
                    (1 - std::cos(2 * pi * (static_cast<double>(n) + 0.5) / count)) / std::sqrt(1.5);
                piece.push_back(hann * error(samples[first + n], axis));
            }
            const std::vector<double> power = power_spectrum(piece);
            for (std::size_t n = 0; n < power.size(); ++n) sum[n] += power[n] / square;
        }
        out.power.push_back(std::move(sum));
    }
    return out;
}

ForceMetrics force_metrics(const std::vector<ForceSample> &samples, double rate, double radius,
                           double crossing, bool periodic)
{
    ForceMetrics m;
    const auto count = static_cast<double>(samples.size());
    Point mean{};
    double square = 0, across = 0, peak = 0, size = 0, turning = 0, jump = 0;
    m.points_min = samples.empty() ? 0 : samples[0].points;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const ForceSample &s = samples[n];
        for (std::size_t i = 0; i < 3; ++i) mean[i] += s.force[i] / count;
        square += s.force[0] * s.force[0] / count;
        const double side = s.force[1] * s.force[1] + s.force[2] * s.force[2];
        across += side / count;
        peak = std::max(peak, std::sqrt(side));
        size += length(s.force) / count;
        turning += length(s.torque);
        if (n > 0) jump = std::max(jump, length(apart(s.force, samples[n - 1].force, 1)));
        m.points_min = std::min(m.points_min, static_cast<double>(s.points));
        m.points_max = std::max(m.points_max, static_cast<double>(s.points));
        m.points_mean += s.points / count;
        m.touching += (length(s.force) > 0) / count;
        m.deep += s.deep / count;
        m.cancelled += s.cancelled / count;
    }
    m.normal = mean[0];
    const double whole = mean[0] > 0 ? mean[0] : nothing;
    const double bias = mean[1] * mean[1] + mean[2] * mean[2];
    m.ripple = std::sqrt(std::max(0.0, square - mean[0] * mean[0])) / whole;
    m.across_rms = std::sqrt(across) / whole;
    m.across_peak = peak / whole;
    m.across_bias = std::sqrt(bias) / whole;
    m.across_noise = std::sqrt(std::max(0.0, across - bias)) / whole;
    m.jump = jump / whole;
    m.size = size;
    m.torque_size = turning / (count * radius);
    against_ideal(samples, radius, size, m);
    m.magnitude_error = magnitude_error(samples);
    const Spectrum spectrum = fluctuation(samples, rate, periodic);
    m.above_10 = spectrum.share(10, rate);
    m.above_30 = spectrum.share(30, rate);
    m.above_100 = spectrum.share(100, rate);
    m.swing_above_10 = std::sqrt(m.above_10 * spectrum.all()) / whole;
    m.at_crossing = crossing > 0 ? spectrum.share(0.95 * crossing, 1.05 * crossing) : nothing;
    m.degenerate = !(size > 0) || peak <= least_across * size;
    return m;
}

ResponseMetrics response_metrics(const std::vector<double> &input, const std::vector<double> &output,
                                 double rate)
{
    ResponseMetrics m;
    const std::size_t count = output.size();
    const std::size_t tail = std::min(count, static_cast<std::size_t>(std::lround(0.3 * rate)));
    if (count == 0 || tail == 0) return m;
    const auto first = static_cast<std::size_t>(
        std::find_if(input.begin(), input.end(), [](double f) { return f != 0; }) - input.begin());
    const auto end = output.end(), begin = end - static_cast<std::ptrdiff_t>(tail);
    for (auto at = begin; at != end; ++at) m.steady += *at / static_cast<double>(tail);
    m.oscillation = *std::max_element(begin, end) - *std::min_element(begin, end);
    const auto passes = [&](double level) {
        for (std::size_t n = first; n < count; ++n) {
            if (output[n] >= level) return static_cast<double>(n) / rate;
        }
        return nothing;
    };
    if (m.steady > 0) {
        m.rise = passes(0.9 * m.steady) - passes(0.1 * m.steady);
        m.overshoot = *std::max_element(output.begin(), end) / m.steady - 1;
        std::size_t last = first;
        for (std::size_t n = first; n < count; ++n) {
            if (std::abs(output[n] - m.steady) > 0.05 * m.steady) last = n + 1;
        }
        m.settling =
            last + tail / 2 < count ? static_cast<double>(last - std::min(last, first)) / rate : nothing;
    } else {
        m.rise = m.overshoot = m.settling = nothing;
    }
    double best = 0;
    m.lag = nothing;
    for (std::size_t lag = 0; lag <= tail && first + lag + 2 < count; ++lag) {
        // Correlation of what overlaps, each without its mean there: a long lag is not punished for a short
        // overlap.
        const auto overlap = static_cast<double>(count - first - lag);
        double in = 0, out = 0, both = 0, in2 = 0, out2 = 0;
        for (std::size_t n = first; n + lag < count; ++n) {
            const double a = input[n], b = output[n + lag];
            in += a;
            out += b;
            both += a * b;
            in2 += a * a;
            out2 += b * b;
        }
        const double spread = (in2 - in * in / overlap) * (out2 - out * out / overlap);
        const double correlation = spread > 0 ? (both - in * out / overlap) / std::sqrt(spread) : 0;
        if (correlation > best) {
            best = correlation;
            m.lag = static_cast<double>(lag) / rate;
        }
    }
    return m;
}

double least_energy(const std::vector<Point> &positions, const std::vector<Point> &forces, unsigned delay)
{
    double energy = 0, least = 0;
    for (std::size_t n = delay + 1; n < positions.size(); ++n) {
        energy -= dot(forces[n - 1 - delay], apart(positions[n], positions[n - 1], 1));
        least = std::min(least, energy);
    }
    return least;
}

MeanAndSpread mean_and_spread(const std::vector<double> &values)
{
    MeanAndSpread m{0, 0, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                    0};
    for (const double value : values) {
        if (!std::isfinite(value)) continue;
        ++m.count;
        m.mean += value;
        m.least = std::min(m.least, value);
        m.most = std::max(m.most, value);
    }
    if (m.count == 0) return {nothing, nothing, nothing, nothing, 0};
    m.mean /= static_cast<double>(m.count);
    for (const double value : values) {
        if (std::isfinite(value)) m.deviation += (value - m.mean) * (value - m.mean);
    }
    m.deviation = m.count > 1 ? std::sqrt(m.deviation / static_cast<double>(m.count - 1)) : 0;
    return m;
}

} // namespace voxshell
