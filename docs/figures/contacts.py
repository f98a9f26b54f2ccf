"""Draw docs/benchmarks/contact_number.png from the table of contacts.md: python docs/figures/contacts.py"""

from pathlib import Path

from nonsmooth.drawing.plots import new_figure

PAGE = Path(__file__).parents[1] / "benchmarks" / "contacts.md"


def rows(page):
    """The rows of the table: a name, and the microseconds of each number of feet."""
    lines = [[cell.strip() for cell in line.strip("| \n").split(" | ")] for line in page.splitlines() if "|" in line]
    numbers = [int(cell) for cell in lines[0][1:]]
    return [(line[0], numbers[-len(line[1:]) :], [float(cell or "nan") for cell in line[1:]]) for line in lines[2:]]


def main():
    figure = new_figure(7.5, 4.2)
    axes = figure.subplots()
    table = rows(PAGE.read_text())
    for k, (name, numbers, microseconds) in enumerate(table):
        is_before = k % 2 == 0
        label = name if is_before else f"{table[k - 1][0].removesuffix(', before')}, now"
        axes.loglog(numbers, microseconds, ":" if is_before else "o-", color=f"C{k // 2}", markersize=3, label=label)
    axes.set_xlabel("feet [-]")
    axes.set_ylabel("processor time a step [us]")
    axes.set_xticks([2, 3, 4, 6, 8, 12, 16], ["2", "3", "4", "6", "8", "12", "16"])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize="small")
    figure.savefig(PAGE.with_name("contact_number.png"), dpi=110)


if __name__ == "__main__":
    main()
