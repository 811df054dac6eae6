"""Tests of sunfleck_tools: run with `python -m unittest discover -s tools/tests -t tools` where the
package is installed."""
