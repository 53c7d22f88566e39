"""Terms that no effect of the catalogue explains, discovered from the error of a balance.

from model_diagnosis.discovery.search import discover
"""
