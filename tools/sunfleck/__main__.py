"""`python -m sunfleck`: the program, with the arguments as they are."""

import os
import subprocess
import sys

from .errors import ProgramError
from .process import program

try:
    command = [program(), *sys.argv[1:]]
except ProgramError as error:
    sys.exit(f"error: {error}")
if os.name == "posix":
    # The program replaces this process, so signals and the exit code are its own.
    os.execv(command[0], command)
sys.exit(subprocess.run(command).returncode)
