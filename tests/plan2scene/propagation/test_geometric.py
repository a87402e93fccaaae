"""What PyTorch Geometric's import costs is paid by predictions alone, without torch's compiler."""

import subprocess
import sys

CODE = """
import sys
import plan2scene.evaluation.comparison, plan2scene.propagation.stage
assert "torch_geometric" not in sys.modules
import torch
from plan2scene.propagation.network import PropagationNetwork
PropagationNetwork(8, 1)(torch.zeros(2, 48), torch.tensor([[0, 1], [1, 0]]))
assert "torch_geometric" in sys.modules and "torch._dynamo" not in sys.modules
from torch_geometric import is_torch_instance
assert is_torch_instance(torch.compile(torch.nn.Linear(1, 1)), torch.nn.Linear)
assert sys.modules["torch._dynamo"].OptimizedModule
"""


def test_the_compiler_is_imported_when_it_is_used():
    subprocess.run([sys.executable, "-c", CODE], check=True)
