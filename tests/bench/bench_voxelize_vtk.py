# SPDX-License-Identifier: GPL-3.0-or-later
"""VTK's polydata stencil on the same cup: bench_voxelize_vtk.py CELLS [RUNS]. Ends with 77 where VTK is not installed."""
import json
import resource
import sys
import time

try:
    import numpy
    import vtk
    from vtk.util import numpy_support
except ImportError:
    sys.exit(77)


def cup(around=300, up=65):
    """As cup.hpp."""
    profile = [(0.040 * i / 20, 0) for i in range(21)] + [(0.040, 0.090 * i / up) for i in range(1, up + 1)]
    profile += [(0.037, 0.090 - 0.087 * i / up) for i in range(up + 1)] + [(0.037 - 0.037 * i / 20, 0.003) for i in range(1, 21)]
    turn = 2 * numpy.pi * numpy.arange(around) / around
    points = numpy.concatenate([numpy.stack([r * numpy.cos(turn), numpy.full(around, y), r * numpy.sin(turn)], 1) for r, y in profile])
    s, n, rows = numpy.arange(around), (numpy.arange(around) + 1) % around, []
    for r in range(len(profile) - 1):
        a, b, c, d = r * around + s, r * around + n, (r + 1) * around + n, (r + 1) * around + s
        rows += [numpy.stack([a, c, b], 1), numpy.stack([a, d, c], 1)]
    return points, numpy.concatenate(rows)


def main():
    cells, runs = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    points, triangles = cup()
    data, coordinates, faces = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    coordinates.SetData(numpy_support.numpy_to_vtk(points, deep=True))
    table = numpy.concatenate([numpy.full((len(triangles), 1), 3), triangles], 1).astype(numpy.int64)
    faces.SetCells(len(triangles), numpy_support.numpy_to_vtkIdTypeArray(table.ravel(), deep=True))
    data.SetPoints(coordinates), data.SetPolys(faces)
    h = 0.090 / cells
    side = int(0.080 / h) + 1
    for _ in range(runs):
        start = time.perf_counter()
        mask = vtk.vtkPolyDataToImageStencil()
        mask.SetInputData(data)
        mask.SetOutputSpacing(h, h, h)
        mask.SetOutputOrigin(-0.040 + h / 2, h / 2, -0.040 + h / 2)
        mask.SetOutputWholeExtent(0, side - 1, 0, cells, 0, side - 1)
        image = vtk.vtkImageStencilToImage()  # the same thing as the others have in the end: cells
        image.SetInputConnection(mask.GetOutputPort())
        image.SetOutputScalarTypeToUnsignedChar()
        image.Update()
        seconds = time.perf_counter() - start
        inside = int(numpy_support.vtk_to_numpy(image.GetOutput().GetPointData().GetScalars()).sum())
        print(json.dumps({'what': 'VTK stencil', 'cells': cells, 'triangles': len(triangles), 'seconds': round(seconds, 4),
                          'inside': inside, 'peak_mib': resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024}))


if __name__ == '__main__':
    main()
