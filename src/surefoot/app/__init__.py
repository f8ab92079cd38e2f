"""What people touch: the command line, pages in a browser, pictures and exports.

`cli` has one file a command, `lab` the pages, `viz` plots, films and reports, `export` contact sequences
for other tools. What stands here may import any module of the package, and nothing imports it.
"""
