"""A made-up score of any length: two groups of 25 dancers, with entries of every kind in each eight measures."""


def score_text(measures: int, dancers: int = 50, calls: int = 1) -> str:
    """Return the text of the patch; `calls` in each eight measures, a beat apart."""
    half = dancers // 2
    blocks = [
        '# Made for a benchmark.\nname = "long"\nseed = 1\n',
        f'[[group]]\nname = "ember"\ndancers = {half}\nsteps = ["groove"]\ncentre = [-3.0, 0.0]\nsize = [5.0, 5.0]\n',
        f'[[group]]\nname = "tide"\ndancers = {dancers - half}\nsteps = ["side step"]\ncentre = [3.0, 0.0]\n'
        "size = [5.0, 5.0]\n",
    ]
    for index, measure in enumerate(range(1, measures, 8)):
        formation = ("circle", "grid", "line", "star:5")[index % 4]
        blocks.append(f"# -- measures {measure} to {measure + 7}\n")
        for group in ("ember", "tide"):
            blocks += [
                f'[[segment]]\nmeasure = {measure}\nmeasures = 4\ngroup = "{group}"\nformation = "{formation}"\n',
                f'[[sequence]]\nmeasure = {measure}\ngroup = "{group}"\n'
                'steps = ["groove x4", "side step x2", "kick", "groove"]  # two phrases\n',
            ]
        blocks += [
            f'[[element]]\nkind = "attract"\nmeasure = {measure + 4}\nmeasures = 2\nat = [1.0, 2.0]\n',
            f'[[signal]]\nname = "s{measure}"\nmeasure = {measure}\n',
        ]
        blocks += [
            f"[[at]]\nmeasure = {measure + 6 - call // 4}\nbeat = {1 + call % 4}\n"
            'call = "/dance/spread"\nvalues = [1]\n'
            for call in range(calls)
        ]
    return "\n".join(blocks)
