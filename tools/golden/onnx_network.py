#!/usr/bin/env python3
"""Makes the network that the tests of fingerpost-onnx run.

    pip install onnx numpy
    python tools/golden/onnx_network.py crates/fingerpost-onnx/tests/models/green_is_road.onnx

Two classes at half the picture's size: the mean of 2 x 2 pixels, then a 1 x 1 convolution. Class 1 (road) has the score
8 (green - red), class 0 has 0, so that the probability by softmax is 1 / (1 + exp(-8 (green - red))).
"""
import sys

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper, save

weights = np.zeros((2, 3, 1, 1), np.float32)
weights[1, 0], weights[1, 1] = -8.0, 8.0
picture = helper.make_tensor_value_info("picture", TensorProto.FLOAT, [1, 3, "height", "width"])
scores = helper.make_tensor_value_info("scores", TensorProto.FLOAT, [1, 2, "rows", "columns"])
graph = helper.make_graph(
    [
        helper.make_node("AveragePool", ["picture"], ["halved"], kernel_shape=[2, 2], strides=[2, 2]),
        helper.make_node("Conv", ["halved", "weights"], ["scores"]),
    ],
    "green_is_road",
    [picture],
    [scores],
    [numpy_helper.from_array(weights, "weights")],
)
model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
checker.check_model(model)
save(model, sys.argv[1])
