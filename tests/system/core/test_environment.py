"""Files that come with the program are found from any folder; files of the user's are written whole."""

import os
import subprocess
import sys

import pytest

from patience import PROGRAM


@pytest.mark.skipif(sys.platform != "linux", reason="other systems count threads elsewhere")
def test_numpy_has_one_thread_in_the_program():
    code = (
        "import os, sys; from grabbergui.__main__ import main\n"
        "sys.argv[1:] = ['--complete', 'bash']; main()\n"
        "import numpy; print(); print(len(os.listdir('/proc/self/task')))"
    )
    variables = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=variables, stdout=subprocess.PIPE, timeout=PROGRAM, check=True
    )
    assert int(done.stdout.split()[-1]) == 1
